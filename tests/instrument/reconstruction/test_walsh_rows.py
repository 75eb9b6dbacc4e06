"""Shifted Walsh rows against the integral of a step function, and against plain sums."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.patterns import walsh_matrix
from instrument.reconstruction import Field
from instrument.reconstruction.walsh_rows import walsh_changes, walsh_rows
from protocols import Floats

SIZE = 8
numbers = st.integers(0, SIZE - 1)
places = st.floats(-2.5 * SIZE, 2.5 * SIZE)
firsts = st.integers(0, 3)
counts = st.integers(1, SIZE - 3)


def _mean_of_steps(number: int, place: float, first: int, count: int) -> Floats:
    """Mean of row ``number`` over each pixel, from its integral: a straight line between whole positions, then constant."""
    integral = np.concatenate([[0.0], np.cumsum(walsh_matrix(SIZE)[number].astype(np.float64))])
    borders = np.interp(first + np.arange(count + 1) + place, np.arange(SIZE + 1), integral)
    return np.diff(borders)


@given(number=numbers, place=places, first=firsts, count=counts)
def test_an_entry_is_the_mean_of_the_step_function_over_its_pixel(
    number: int, place: float, first: int, count: int
) -> None:
    rows = walsh_rows(Field(SIZE), np.array([number]), np.array([place]), first, count)
    assert rows.shape == (1, count)
    np.testing.assert_allclose(rows[0], _mean_of_steps(number, place, first, count), atol=2e-6)


@given(number=numbers, place=places, first=firsts, count=counts, seed=st.integers(0, 100))
def test_the_changes_of_a_row_weigh_the_cumulative_sum_of_a_series(
    number: int, place: float, first: int, count: int, seed: int
) -> None:
    series = np.random.default_rng(seed).standard_normal(count)
    changes = walsh_changes(Field(SIZE), np.array([number]), np.array([place]), first, count)
    assert changes.shape == (1, count)
    assert (changes @ np.cumsum(series))[0] == pytest.approx(
        float(_mean_of_steps(number, place, first, count) @ series), abs=1e-9
    )


@given(number=numbers, whole=st.integers(-10, 10), part=st.floats(0.1, 0.9))
def test_the_slope_is_the_change_of_an_entry_over_a_hundredth_of_a_pixel(number: int, whole: int, part: float) -> None:
    """Between whole places the rows are straight lines, so that a difference is exact."""
    before, after = (_mean_of_steps(number, whole + part + step, 0, SIZE) for step in (-0.005, 0.005))
    slope = walsh_rows(Field(SIZE), np.array([number]), np.array([whole + part]), 0, SIZE, slope=True)
    np.testing.assert_allclose(slope[0], (after - before) / 0.01, atol=1e-6)


def test_at_a_whole_place_the_slope_is_that_of_a_motion_to_the_right() -> None:
    """w_1 of four pixels is + + - -; an object at 0 that goes on loses at its second pixel 2, at its last -1, a pixel."""
    assert walsh_rows(Field(4), np.array([1]), np.array([0.0]), 0, 4, slope=True).tolist() == [[0, -2, 0, 1]]


def test_a_row_of_c_changes_has_c_plus_two_steps_of_two_weights_each() -> None:
    """At a place that is not whole no two weights meet: w_3 of 8 pixels changes at 2, 4 and 6, and begins and ends."""
    changes = walsh_changes(Field(8), np.array([3]), np.array([-2.5]), 0, 12)
    assert changes.nnz == 2 * (3 + 2)
    assert changes.toarray()[0].tolist() == [0, -0.5, -0.5, 1, 1, -1, -1, 1, 1, -0.5, -0.5, 0]


def test_each_row_keeps_its_own_number_and_place() -> None:
    """Rows of 2 and 1 sign changes of four pixels, moved by +1 and -1."""
    rows = walsh_rows(Field(4), np.array([2, 1]), np.array([1.0, -1.0]), 0, 4)
    assert rows.tolist() == [[-1, -1, 1, 0], [0, 1, 1, -1]]


@pytest.mark.parametrize("place", [-1e9, -12.0, 8.0, 1e9])
def test_out_of_the_field_a_row_is_dark_and_has_no_slope(place: float) -> None:
    """Region of 4 pixels from 8 - 4 on: it has left at -12 and at 8 - 4 = 4, and so at 8."""
    for slope in (False, True):
        assert not walsh_rows(Field(8), np.array([0]), np.array([place]), 4, 4, slope=slope).any()
    weights = walsh_changes(Field(8), np.array([0]), np.array([place]), 4, 4).toarray()
    assert float((weights @ np.cumsum([1.0, 2.0, 3.0, 4.0]))[0]) == 0
