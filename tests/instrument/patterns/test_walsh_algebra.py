"""Walsh rows by their algebra: products, halves and mirror images; and whole orders by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.patterns import hadamard_order, hadamard_signs, walsh_matrix

SIZE = 32
rows = st.integers(0, SIZE - 1)


@given(one=rows, other=rows)
def test_the_product_of_two_walsh_rows_is_the_row_of_their_exclusive_or(one: int, other: int) -> None:
    """Walsh functions by sign changes form a group: w_i w_j = w_(i xor j)."""
    walsh = walsh_matrix(SIZE)
    assert (walsh[one] * walsh[other]).tolist() == walsh[one ^ other].tolist()


@given(row=rows)
def test_a_walsh_row_is_even_or_odd_as_its_number_is(row: int) -> None:
    walsh = walsh_matrix(SIZE)
    assert walsh[row, ::-1].tolist() == ((-1) ** row * walsh[row]).tolist()


@given(row=rows)
def test_half_of_a_walsh_row_is_the_row_of_half_its_number(row: int) -> None:
    """2 k sign changes are k in each half; 2 k + 1 have one more in the middle. The first entry is +1."""
    walsh = walsh_matrix(SIZE)
    assert walsh[row, : SIZE // 2].tolist() == walsh_matrix(SIZE // 2)[row // 2].tolist()
    assert walsh[row, 0] == 1


def test_the_smallest_walsh_matrices_are_those_of_one_and_two_pixels() -> None:
    assert walsh_matrix(1).tolist() == [[1]]
    assert walsh_matrix(2).tolist() == [[1, 1], [1, -1]]


@pytest.mark.parametrize("size", [-4, 0, 3, 6, 127])
def test_no_other_size_than_a_power_of_two_has_a_walsh_matrix(size: int) -> None:
    with pytest.raises(ValueError, match=f"size is {size}: "):
        walsh_matrix(size)


def test_walsh_rows_are_made_once_and_nobody_can_change_them() -> None:
    walsh = walsh_matrix(8)
    assert walsh_matrix(8) is walsh
    with pytest.raises(ValueError, match="read-only"):
        walsh[0, 0] = -1


def test_the_whole_tv_order_of_three_steps_by_hand() -> None:
    """Sums 0 to 6 of two numbers from 0 to 3, the smaller c_i first."""
    assert hadamard_order(4, "tv").tolist() == [
        [0, 0],
        [0, 1], [1, 0],
        [0, 2], [1, 1], [2, 0],
        [0, 3], [1, 2], [2, 1], [3, 0],
        [1, 3], [2, 2], [3, 1],
        [2, 3], [3, 2],
        [3, 3],
    ]  # fmt: skip


def test_the_whole_hyperbolic_order_by_hand() -> None:
    """Products 1, 2, 3, 4, 6, 8, 9, 12 and 16 of two numbers from 1 to 4, the smaller c_i first."""
    assert hadamard_order(4, "hyperbolic").tolist() == [
        [0, 0],
        [0, 1], [1, 0],
        [0, 2], [2, 0],
        [0, 3], [1, 1], [3, 0],
        [1, 2], [2, 1],
        [1, 3], [3, 1],
        [2, 2],
        [2, 3], [3, 2],
        [3, 3],
    ]  # fmt: skip


@pytest.mark.parametrize("count", [0, 1, 16, 17])
def test_an_order_has_as_many_patterns_as_were_asked_for(count: int) -> None:
    pairs = hadamard_order(4, "tv", count)
    assert pairs.shape == (count, 2)
    assert pairs[16:].tolist() == [[0, 0]][: max(0, count - 16)]


def test_the_first_of_a_pair_counts_down_the_image_and_the_second_across() -> None:
    """(1, 3) of four pixels: + + - - from top to bottom, + - + - from left to right."""
    (pattern,) = hadamard_signs(4, np.array([[1, 3]]))
    assert pattern.tolist() == [[1, -1, 1, -1], [1, -1, 1, -1], [-1, 1, -1, 1], [-1, 1, -1, 1]]
