"""Walsh rows, and the orders in which Hadamard patterns are shown."""

from typing import get_args

import numpy as np
import pytest

from instrument.patterns import hadamard_order, hadamard_signs, walsh_matrix
from instrument.patterns.hadamard import HadamardOrder


@pytest.mark.parametrize("size", [8, 64, 128])
def test_walsh_row_c_changes_sign_c_times_and_rows_are_orthogonal(size: int) -> None:
    walsh = walsh_matrix(size).astype(np.int64)

    assert np.count_nonzero(np.diff(walsh, axis=1), axis=1).tolist() == list(range(size))
    np.testing.assert_array_equal(walsh @ walsh.T, size * np.eye(size))
    np.testing.assert_array_equal(walsh, walsh.T)


def test_walsh_rows_of_four_pixels_are_the_textbook_ones() -> None:
    assert walsh_matrix(4).tolist() == [[1, 1, 1, 1], [1, 1, -1, -1], [1, -1, -1, 1], [1, -1, 1, -1]]


def test_tv_order_ascends_in_the_anisotropic_total_variation_of_the_patterns_themselves() -> None:
    """2 m (c_i + c_j) for values -1 and +1: each sign change costs 2, along m columns or rows."""
    size = 16
    pairs = hadamard_order(size, "tv")
    patterns = hadamard_signs(size, pairs).astype(np.int64)

    variation = np.abs(np.diff(patterns, axis=1)).sum((1, 2)) + np.abs(np.diff(patterns, axis=2)).sum((1, 2))

    assert (np.diff(variation) >= 0).all()
    np.testing.assert_array_equal(variation, 2 * size * pairs.sum(axis=1))


def test_tv_order_starts_at_the_all_one_pattern_and_breaks_ties_by_rows() -> None:
    assert hadamard_order(128, "tv", 6).tolist() == [[0, 0], [0, 1], [1, 0], [0, 2], [1, 1], [2, 0]]


def test_hyperbolic_order_takes_long_stripes_first() -> None:
    pairs = hadamard_order(128, "hyperbolic")

    assert pairs[:5].tolist() == [[0, 0], [0, 1], [1, 0], [0, 2], [2, 0]]
    assert (np.diff((pairs + 1).prod(axis=1)) >= 0).all()


def test_natural_order_is_sylvesters_matrix() -> None:
    """Sylvester of order 4 by hand: rows of 0, 3, 1 and 2 sign changes."""
    assert hadamard_order(4, "natural")[:, 1].reshape(4, 4).tolist() == [[0, 3, 1, 2]] * 4
    flat = hadamard_signs(4, hadamard_order(4, "natural")).reshape(16, 16).astype(np.int64)
    sylvester = np.array([[(-1) ** (i & j).bit_count() for j in range(16)] for i in range(16)])
    np.testing.assert_array_equal(flat, sylvester)


@pytest.mark.parametrize("order", get_args(HadamardOrder))
def test_every_order_holds_every_pattern_once_and_then_starts_again(order: HadamardOrder) -> None:
    pairs = hadamard_order(8, order, 70)

    assert len({tuple(pair) for pair in pairs[:64].tolist()}) == 64
    np.testing.assert_array_equal(pairs[64:], pairs[:6])


def test_a_size_that_is_no_power_of_two_is_refused() -> None:
    with pytest.raises(ValueError, match="size is 12: Hadamard matrices are made for powers of two"):
        walsh_matrix(12)
