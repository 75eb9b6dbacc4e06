"""Figures of merit by hand and against scikit-image."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument.numerics.metrics import displacement_mse, offset_free_mse, psnr, ssim_global, ssim_local
from protocols import Floats


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


@settings(deadline=None)
@given(shift=st.tuples(st.floats(-100, 100), st.floats(-100, 100)), factor=st.integers(1, 9))
def test_an_offset_counts_by_its_square_unless_it_is_left_out(shift: tuple[float, float], factor: int) -> None:
    """Errors of mean 0 that grow ``factor`` times, and an offset on top of them, whose halved square is added."""
    truth = np.zeros((4, 2))
    error = factor * np.array([[1.0, -2.0], [-1.0, 2.0], [3.0, 0.0], [-3.0, 0.0]])
    mean_square = factor**2 * 28 / 8

    assert offset_free_mse(error + shift, truth) == pytest.approx(mean_square)
    expected = mean_square + (shift[0] ** 2 + shift[1] ** 2) / 2
    assert displacement_mse(error + shift, truth) == pytest.approx(expected)


def test_a_dark_image_has_no_gain_to_fit() -> None:
    """Against a truth of 1/2 everywhere its error is 1/4, 6.02 dB below 1, with a gain or without."""
    dark, truth = np.zeros((3, 3)), np.full((3, 3), 0.5)
    assert psnr(dark, truth, fit_gain=True) == psnr(dark, truth) == pytest.approx(10 * np.log10(4))


def test_the_gain_is_that_of_least_squares() -> None:
    """(0.2, 0.4) against (0.2, 0.9): gain 0.4 / 0.2 = 2, so (0.4, 0.8), errors 0.2 and 0.1, mean square 0.025."""
    image, truth = np.array([[0.2, 0.4]]), np.array([[0.2, 0.9]])
    assert psnr(image, truth, fit_gain=True) == pytest.approx(-10 * np.log10(0.025))


@pytest.mark.parametrize("similarity", [ssim_local, ssim_global])
def test_of_flat_images_only_the_brightness_differs(similarity: Callable[[Floats, Floats], float]) -> None:
    """Means 0.25 and 0.75, nothing else: (2 x 0.1875 + 0.0001) / (0.0625 + 0.5625 + 0.0001)."""
    found = similarity(np.full((13, 12), 0.25), np.full((13, 12), 0.75))
    assert found == pytest.approx(0.3751 / 0.6251, abs=1e-9)


@pytest.mark.parametrize("similarity", [ssim_local, ssim_global])
def test_similarity_with_a_gain_does_not_feel_the_scale(similarity: Callable[..., float]) -> None:
    truth = np.random.default_rng(1).random((12, 14))
    assert similarity(truth / 5, truth, fit_gain=True) == pytest.approx(1.0)
    assert similarity(truth / 5, truth) < 0.7


def test_similarity_looks_no_nearer_to_the_border_than_half_a_window() -> None:
    """Of 11 x 11 pixels one window is whole: that of the middle, whose Gaussian weights are those of sigma 1.5."""
    rng = np.random.default_rng(2)
    image, truth = rng.random((11, 11)), rng.random((11, 11))
    line = np.exp(-(np.arange(-5.0, 6.0) ** 2) / 4.5)
    window = np.outer(line, line) / line.sum() ** 2
    mean_a, mean_b = float((window * image).sum()), float((window * truth).sum())
    var_a, var_b = float((window * image**2).sum()) - mean_a**2, float((window * truth**2).sum()) - mean_b**2
    both = float((window * image * truth).sum()) - mean_a * mean_b
    luminance = (2 * mean_a * mean_b + 1e-4) / (mean_a**2 + mean_b**2 + 1e-4)
    assert ssim_local(image, truth) == pytest.approx(luminance * (2 * both + 9e-4) / (var_a + var_b + 9e-4))
