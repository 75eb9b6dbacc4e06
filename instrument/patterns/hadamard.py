"""Hadamard patterns as outer products of Walsh rows, and the orders in which to show them."""

from functools import lru_cache
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from protocols import Integers

Signs: TypeAlias = NDArray[np.int8]
"""Values -1 and +1."""

HadamardOrder: TypeAlias = Literal["tv", "hyperbolic", "natural"]
"""Name of an order; see ``hadamard_order``."""


@lru_cache(maxsize=8)
def walsh_matrix(size: int) -> Signs:
    """Give the Walsh rows by ascending number of sign changes: row c changes sign c times.

    Args:
        size: number of rows, a power of two.

    Returns:
        ``(size, size)`` of -1 and +1, symmetric, with orthogonal rows. The array is made once, kept, and read-only.

    Raises:
        ValueError: ``size`` is no power of two.
    """
    rows = _natural(size)[np.argsort(_sign_changes(size))]
    rows.flags.writeable = False
    return rows


def hadamard_order(size: int, order: HadamardOrder, count: int | None = None) -> Integers:
    """List Hadamard patterns as pairs of Walsh rows (c_i down, c_j across), in the order in which they are shown.

    ``tv`` is ascending total variation, 2 m (c_i + c_j). ``hyperbolic`` is ascending (c_i + 1)(c_j + 1). ``natural`` is the order
    of Sylvester's matrix, k = size * i + j with i and j counting its rows. Ties are broken by c_i, so that each order is unique.

    Args:
        size: image pixels a side, a power of two.
        order: name of the order.
        count: number of patterns; None for all ``size ** 2``. After the last pattern the first one follows again.

    Returns:
        Numbers of sign changes c_i and c_j, ``(count, 2)``.

    References:
        Yu et al., Scientific Reports 10 (2020), doi 10.1038/s41598-020-66371-5: ascending total variation.
    """
    changes = np.arange(size)
    if order == "natural":
        changes = _sign_changes(size)
    down, across = (axis.ravel() for axis in np.meshgrid(changes, changes, indexing="ij"))
    if order == "tv":
        rank = np.lexsort((down, down + across))
    elif order == "hyperbolic":
        rank = np.lexsort((down, (down + 1) * (across + 1)))
    else:
        rank = np.arange(size * size)
    pairs = np.stack([down, across], axis=1)[rank].astype(np.int64)
    return pairs if count is None else pairs[np.arange(count) % len(pairs)]


def hadamard_signs(size: int, pairs: Integers) -> Signs:
    """Give the patterns H = w_i(y) w_j(x) of the pairs listed.

    Args:
        size: image pixels a side.
        pairs: ``(n, 2)`` Walsh rows, as from ``hadamard_order``.

    Returns:
        The patterns, ``(n, size, size)`` of -1 and +1, row = y.
    """
    walsh = walsh_matrix(size)
    return walsh[pairs[:, 0], :, None] * walsh[pairs[:, 1], None, :]


def _natural(size: int) -> Signs:
    """Give Sylvester's matrix: H_2n holds H_n four times, with the opposite sign in its lower right quarter."""
    if size < 1 or size & (size - 1):
        raise ValueError(f"size is {size}: Hadamard matrices are made for powers of two")
    matrix = np.ones((1, 1), np.int8)
    while len(matrix) < size:
        matrix = np.block([[matrix, matrix], [matrix, -matrix]])
    return matrix


def _sign_changes(size: int) -> Integers:
    """Count the sign changes of each row of Sylvester's matrix."""
    changes: Integers = np.count_nonzero(np.diff(_natural(size), axis=1), axis=1).astype(np.int64)
    return changes
