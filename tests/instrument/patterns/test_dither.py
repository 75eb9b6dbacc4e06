"""Error diffusion by hand, and what it keeps of the grey values whatever they are."""

from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.patterns import floyd_steinberg, moment_pattern, ramp
from protocols import Floats

seeds = st.integers(0, 10_000)
sides = st.integers(1, 12)


def _grey(seed: int, rows: int, columns: int) -> Floats:
    return np.random.default_rng(seed).random((rows, columns))


def _most_lost(rows: int, columns: int) -> float:
    """Error that can leave: half a sample, times 9/16 for each in the last row and 11/16 for the two side columns."""
    return 0.5 * (columns * 9 + rows * 11) / 16


def test_a_row_of_half_grey_becomes_every_second_sample() -> None:
    """0.5 is lit, and leaves -0.5 * 7/16: 0.281 is dark, then 0.623 is lit, then 0.335 is dark."""
    assert floyd_steinberg(np.full((1, 4), 0.5)).tolist() == [[1, 0, 1, 0]]


def test_the_second_row_gets_what_the_first_one_lacked() -> None:
    """Grey of 0.4, two columns: 0.4 and 0.575 are dark and lit; the errors are 0.4 and -0.425.

    Below, the left sample is 0.4 + 0.4 * 5/16 - 0.425 * 3/16 = 0.445, dark; the right one is
    0.4 + 0.4 * 1/16 - 0.425 * 5/16 + 0.445 * 7/16 = 0.487, dark.
    """
    assert floyd_steinberg(np.full((2, 2), 0.4)).tolist() == [[0, 1], [0, 0]]


def test_a_sample_hands_nothing_round_the_border_to_the_next_row() -> None:
    """One column: each sample gets 5/16 of the error above it and nothing else.

    0.45 is dark; 0.45 + 0.141 is lit, 0.409 too much; 0.45 - 0.128 is dark; 0.45 + 0.101 is lit.
    """
    assert floyd_steinberg(np.full((4, 1), 0.45)).tolist() == [[0], [1], [0], [1]]


@given(seed=seeds, rows=sides, columns=sides)
def test_a_binary_pattern_stays_what_it_is(seed: int, rows: int, columns: int) -> None:
    binary = (_grey(seed, rows, columns) > 0.5).astype(np.float64)
    dithered = floyd_steinberg(binary)
    assert dithered.dtype == np.uint8
    np.testing.assert_array_equal(dithered, binary)


@given(seed=seeds, rows=sides, columns=sides)
def test_the_complement_of_the_grey_values_is_the_complement_of_the_pattern(seed: int, rows: int, columns: int) -> None:
    """An error and its opposite are handed on alike; random grey values never fall on the threshold."""
    grey = _grey(seed, rows, columns)
    np.testing.assert_array_equal(floyd_steinberg(1 - grey), 1 - floyd_steinberg(grey))


@given(seed=seeds, rows=sides, columns=sides)
def test_light_is_lost_at_the_borders_only(seed: int, rows: int, columns: int) -> None:
    """No sample is wrong by more than 1/2, and inside the pattern all of its error arrives somewhere."""
    grey = _grey(seed, rows, columns)
    assert abs(float(floyd_steinberg(grey).sum()) - grey.sum()) <= _most_lost(rows, columns) + 1e-9


@given(seed=seeds, rows=st.integers(2, 12), columns=sides, first=st.integers(1, 11))
def test_a_row_does_not_depend_on_the_rows_below(seed: int, rows: int, columns: int, first: int) -> None:
    grey = _grey(seed, rows, columns)
    upper = min(first, rows - 1)
    np.testing.assert_array_equal(floyd_steinberg(grey)[:upper], floyd_steinberg(grey[:upper]))


@pytest.mark.parametrize("upsampling", [2, 3, 8])
def test_a_coarse_ramp_is_the_mean_of_a_fine_one(upsampling: int) -> None:
    """The mean of a straight line over a pixel is its value in the middle."""
    fine = ramp(6, "x", upsampling).reshape(6, upsampling, 6, upsampling).mean(axis=(1, 3))
    np.testing.assert_allclose(fine, ramp(6, "x"), atol=1e-14)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_ramp_and_its_mirror_image_add_up_to_full_light(axis: Literal["x", "y"]) -> None:
    grey = ramp(8, axis)
    mirrored = grey[:, ::-1] if axis == "x" else grey[::-1]
    np.testing.assert_allclose(grey + mirrored, 1.0, atol=1e-15)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_moment_pattern_lets_half_of_the_light_through_and_more_towards_its_end(axis: Literal["x", "y"]) -> None:
    """A ramp of 64 x 64 has 2048 lit samples but for what the borders lose, and its quarters 1/8, 3/8, 5/8 and 7/8."""
    pattern = moment_pattern(32, axis, 2).astype(np.float64)
    along = pattern if axis == "x" else pattern.T
    assert abs(pattern.sum() - 2048) <= _most_lost(64, 64)
    np.testing.assert_allclose(along.reshape(64, 4, 16).mean(axis=(0, 2)), [1 / 8, 3 / 8, 5 / 8, 7 / 8], atol=0.02)
