"""Figures of merit by hand and against scikit-image."""

from importlib import import_module
from typing import Any

import numpy as np
import pytest

from instrument.numerics.metrics import displacement_mse, offset_free_mse, psnr, ssim_global, ssim_local


def test_displacement_mse_is_the_mean_over_frames_and_axes() -> None:
    """Errors 1, 1 in x and 0, 2 in y: (1 + 1 + 0 + 4) / 4; without the means 1 and 1: (0 + 0 + 1 + 1) / 4."""
    truth = np.array([[0.0, 0.0], [5.0, 5.0]])
    found = truth + np.array([[1.0, 0.0], [1.0, 2.0]])
    assert displacement_mse(found, truth) == 1.5
    assert offset_free_mse(found, truth) == 0.5


def test_psnr_of_an_error_of_a_tenth_is_twenty_decibels() -> None:
    truth = np.full((4, 4), 0.5)
    assert psnr(truth + 0.1, truth) == pytest.approx(20.0)
    assert psnr(truth, truth) == float("inf")


def test_psnr_clips_to_what_a_transmission_can_be() -> None:
    """Where the truth is 1 and 0, 1.7 and -3 are no error."""
    assert psnr(np.array([[1.7, -3.0]]), np.array([[1.0, 0.0]])) == float("inf")


def test_psnr_with_a_gain_does_not_feel_the_scale() -> None:
    truth = np.random.default_rng(0).random((8, 8))
    noisy = truth + 0.05
    assert psnr(7 * noisy, truth, fit_gain=True) == pytest.approx(psnr(noisy, truth, fit_gain=True))
    assert psnr(3 * truth, truth, fit_gain=True) > 200


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_local_ssim_equals_scikit_image(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = rng.random((40, 33))
    image = np.clip(truth + 0.2 * rng.standard_normal(truth.shape), 0, 1)
    metrics: Any = import_module("skimage.metrics")  # untyped
    expected: float = metrics.structural_similarity(
        truth, image, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1
    )
    assert ssim_local(image, truth) == pytest.approx(expected, abs=1e-12)


def test_global_ssim_of_an_inverted_image_is_that_of_the_formula() -> None:
    """Means 1/2, variances 1/4, covariance -1/4: (2 * -1/4 + 0.0009) / (1/2 + 0.0009)."""
    truth = np.array([[0.0, 1.0], [1.0, 0.0]])
    assert ssim_global(1 - truth, truth) == pytest.approx(-0.4991 / 0.5009)
    assert ssim_global(truth, truth) == pytest.approx(1.0)
