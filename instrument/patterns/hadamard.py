"""Hadamard patterns as outer products of Walsh rows, and the orders in which to show them."""

import math
from functools import lru_cache
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from protocols import Integers

Signs: TypeAlias = NDArray[np.int8]
"""Values -1 and +1."""

HadamardOrder: TypeAlias = Literal[
    "tv", "tv-isotropic", "hyperbolic", "cake-cutting", "zig-zag", "sequency", "natural", "random"
]
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


def hadamard_order(size: int, order: HadamardOrder, count: int | None = None, seed: int = 0) -> Integers:
    """List Hadamard patterns as pairs of Walsh rows (c_i down, c_j across), in the order in which they are shown.

    ========================  =====================================================  ========================
    order                     ascending                                              patterns that are alike
    ========================  =====================================================  ========================
    ``tv``                    total variation, the sum of both differences,          ascending c_i
                              2 m (c_i + c_j)
    ``tv-isotropic``          total variation, the root of the sum of their          ascending c_i
                              squares, 2 m (c_i + c_j) - 2 (2 - sqrt 2) c_i c_j
    ``hyperbolic``            (c_i + 1)(c_j + 1)                                     ascending c_i
    ``cake-cutting``          number of connected regions, which is the same number  as in ``natural``
    ``zig-zag``               c_i + c_j, along the diagonals of the square of all    to and fro in turn
                              (c_i, c_j)
    ``sequency``              sign changes of the pattern read line by line, those   there are none
                              from the end of a line to the next included
    ``natural``               row of Sylvester's matrix of m^2 rows                  there are none
    ``random``                a permutation drawn from ``seed``                      there are none
    ========================  =====================================================  ========================

    Args:
        size: image pixels a side (m), a power of two.
        order: name of the order.
        count: number of patterns; None for all ``size ** 2``. After the last pattern the first one follows again.
        seed: of ``random``; the others have none.

    Returns:
        Numbers of sign changes c_i and c_j, ``(count, 2)``.

    References:
        ``tv``: X. Yu, R. I. Stantchev, F. Yang, E. Pickwell-MacPherson, Scientific Reports 10 (2020) 9338. Which of both norms
        they use we could not read.
        ``hyperbolic``: D. Dung, V. Temlyakov, T. Ullrich, "Hyperbolic Cross Approximation", Birkhauser (2018): the set of the
        first n is a hyperbolic cross.
        ``cake-cutting``: W.-K. Yu, Sensors 19 (2019) 4122.
        ``zig-zag``: L. Lopez-Garcia et al., Opt. Express 30 (2022) 13714.
        ``sequency``: J. L. Walsh, Am. J. Math. 45 (1923) 5.
        ``natural``: J. J. Sylvester, Phil. Mag. 34 (1867) 461.
    """
    down, across = (axis.ravel() for axis in np.meshgrid(np.arange(size), np.arange(size), indexing="ij"))
    rank = _rank(order, down, across, seed)
    pairs = np.stack([down, across], axis=1)[rank].astype(np.int64)
    return pairs if count is None else pairs[np.arange(count) % len(pairs)]


def _rank(order: HadamardOrder, down: Integers, across: Integers, seed: int) -> Integers:
    """Give the permutation, ``(m m,)``, that sorts the pairs (down, across), which come in lines of ascending numbers."""
    size = math.isqrt(len(down))
    regions, diagonal = (down + 1) * (across + 1), down + across
    sylvester = np.argsort(_sign_changes(size))  # row of Sylvester's matrix with c sign changes, for each c
    natural = size * sylvester[down] + sylvester[across]
    keys: tuple[NDArray[Any], ...]
    if order == "tv":
        keys = (down, diagonal)
    elif order == "tv-isotropic":
        variation = size * diagonal - (2 - np.sqrt(2)) * down * across
        keys = (down, variation.round(6))
    elif order == "hyperbolic":
        keys = (down, regions)
    elif order == "cake-cutting":
        keys = (natural, regions)
    elif order == "zig-zag":
        keys = (np.where(diagonal % 2, down, across), diagonal)
    elif order == "sequency":
        between_lines = np.where(across % 2, size - 1 - down, down)
        keys = (size * across + between_lines,)
    elif order == "natural":
        keys = (natural,)
    else:
        return np.random.default_rng(seed).permutation(size * size).astype(np.int64)
    return np.lexsort(keys).astype(np.int64)


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
