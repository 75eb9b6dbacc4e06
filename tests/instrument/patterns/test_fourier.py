"""Fringes and their dithering."""

from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from instrument.patterns import floyd_steinberg, fourier_pattern, fringe
from protocols import Floats


def test_error_diffusion_of_four_grey_pixels_by_hand() -> None:
    """0.4 -> 0, error 0.4: right 0.6 + 0.175 -> 1 (error -0.225), below 0.2 + 0.125 - 0.0421875 -> 0, last 0.7 + ... -> 1."""
    assert floyd_steinberg(np.array([[0.4, 0.6], [0.2, 0.7]])).tolist() == [[0, 1], [0, 1]]


def test_a_value_of_exactly_one_half_is_lit() -> None:
    assert floyd_steinberg(np.array([[0.5]])).tolist() == [[1]]


@settings(max_examples=30, deadline=None)
@given(arrays(np.float64, (6, 9), elements=st.floats(0, 1)))
def test_dithering_makes_bits_and_keeps_the_light_but_for_what_leaves_at_the_border(grey: Floats) -> None:
    """A row's error is at most 1/2; no more than that leaves at each border sample."""
    binary = floyd_steinberg(grey)

    assert set(np.unique(binary).tolist()) <= {0, 1}
    assert abs(float(grey.sum() - binary.sum())) <= (9 + 2 * 6) / 2


@pytest.mark.parametrize("phase", [0.0, np.pi / 2])
@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_dithered_fringe_and_its_complement_make_the_all_one_pattern(axis: Literal["x", "y"], phase: float) -> None:
    """So the complement's Fourier coefficient is minus the pattern's, as a phase turned by pi asks, dithering and all."""
    pattern = fourier_pattern(64, 2, phase, axis).astype(np.float64)
    wave = np.exp(-2j * np.pi * 2 * np.arange(64) / 64)
    weights = np.outer(np.ones(64), wave) if axis == "x" else np.outer(wave, np.ones(64))

    complement = 1 - pattern

    assert set(np.unique(complement).tolist()) == {0.0, 1.0}
    assert abs((complement * weights).sum() + (pattern * weights).sum()) < 1e-9
    # The fringe's own is 64^2 / 4; error diffusion, which goes right and down only, turns and changes it by less than 8 %.
    assert abs((pattern * weights).sum() - 64**2 / 4 * np.exp(1j * phase)) < 0.08 * 64**2 / 4


def test_fringe_is_a_raised_cosine_along_its_axis() -> None:
    along_x = fringe(8, 1, 0.0, "x")

    assert along_x.shape == (8, 8)
    np.testing.assert_allclose(along_x[3], 0.5 + 0.5 * np.cos(2 * np.pi * np.arange(8) / 8))
    np.testing.assert_array_equal(fringe(8, 1, 0.0, "y"), along_x.T)


def test_upsampled_samples_stand_about_their_pixel() -> None:
    """Two samples a pixel, at -1/4 and +1/4 of it."""
    np.testing.assert_allclose(
        fringe(8, 1, 0.0, "x", 2)[0, :4], 0.5 + 0.5 * np.cos(2 * np.pi * np.array([-0.25, 0.25, 0.75, 1.25]) / 8)
    )
