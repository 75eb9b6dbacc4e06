"""The orders of the Hadamard patterns against matrices and counts that are made without them."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import hadamard
from scipy.ndimage import label

from instrument.patterns import HadamardOrder, hadamard_order, hadamard_signs

Patterns = NDArray[np.int64]


def shown(size: int, order: HadamardOrder) -> Patterns:
    """Give the patterns in their order, each a line."""
    return hadamard_signs(size, hadamard_order(size, order)).reshape(size * size, -1).astype(np.int64)


def sylvester(size: int) -> Patterns:
    """SciPy's matrix, whose rows are the patterns in natural order."""
    return np.asarray(hadamard(size * size), np.int64)


def test_natural_is_scipys_matrix() -> None:
    np.testing.assert_array_equal(shown(8, "natural"), sylvester(8))


def test_sequency_is_scipys_matrix_by_its_number_of_sign_changes() -> None:
    """Walsh: row k of m^2 changes sign k times."""
    matrix = sylvester(8)
    changes = np.count_nonzero(np.diff(matrix, axis=1), axis=1)

    np.testing.assert_array_equal(shown(8, "sequency"), matrix[np.argsort(changes)])
    np.testing.assert_array_equal(np.count_nonzero(np.diff(shown(8, "sequency"), axis=1), axis=1), np.arange(64))


def test_cake_cutting_is_scipys_matrix_by_its_number_of_pieces() -> None:
    """Pieces are connected regions of one sign, side by side; those with as many keep their natural order (Yu 2019)."""
    matrix = sylvester(8)
    pieces = [label(line.reshape(8, 8) > 0)[1] + label(line.reshape(8, 8) < 0)[1] for line in matrix]

    np.testing.assert_array_equal(shown(8, "cake-cutting"), matrix[np.argsort(pieces, kind="stable")])


@pytest.mark.parametrize("order", ["tv", "tv-isotropic"])
def test_both_norms_ascend_in_the_total_variation_of_the_patterns_themselves(order: HadamardOrder) -> None:
    """Forward differences, of which there are none at the last row and column."""
    patterns = shown(8, order).reshape(-1, 8, 8)
    down = np.diff(patterns, axis=1, append=patterns[:, -1:])
    across = np.diff(patterns, axis=2, append=patterns[:, :, -1:])
    size = np.abs(down) + np.abs(across) if order == "tv" else np.hypot(down, across)

    variation = size.sum(axis=(1, 2)).round(6)

    assert (np.diff(variation) >= 0).all()
    assert len(np.unique(variation)) > 14


def test_the_isotropic_norm_takes_a_cross_before_three_stripes() -> None:
    """At m = 4, 8 (c_i + c_j) - 1.17 c_i c_j: 14.83 for (1, 1), 16 for (0, 2); 21.66 for (1, 2), 24 for (0, 3)."""
    assert hadamard_order(4, "tv-isotropic", 11).tolist() == [
        *([0, 0], [0, 1], [1, 0]),
        *([1, 1], [0, 2], [2, 0]),
        *([1, 2], [2, 1], [0, 3], [3, 0], [2, 2]),
    ]


def test_zig_zag_goes_to_and_fro_along_the_diagonals() -> None:
    """4 x 4, as the coefficients of a JPEG block are numbered: right, down left, down, up right, ..."""
    number = np.empty((4, 4), np.int64)
    number[tuple(hadamard_order(4, "zig-zag").T)] = np.arange(16)

    assert number.tolist() == [[0, 1, 5, 6], [2, 4, 7, 12], [3, 8, 11, 13], [9, 10, 14, 15]]


def test_the_first_cake_cuttings_of_four_by_four_by_hand() -> None:
    """1 piece; 2; 3 and 3; 4 each for three stripes and for the cross: Sylvester's rows are of 0, 3, 1 and 2 sign changes."""
    assert hadamard_order(4, "cake-cutting", 8).tolist() == [
        [0, 0],
        [0, 1],
        [1, 0],
        [0, 2],
        [2, 0],
        [0, 3],
        [3, 0],
        [1, 1],
    ]


def test_a_random_order_is_that_of_its_seed() -> None:
    first, again, other = (hadamard_order(8, "random", seed=seed).tolist() for seed in (1, 1, 2))

    assert first == again
    assert first != other
    assert hadamard_order(8, "tv", seed=1).tolist() == hadamard_order(8, "tv").tolist()
