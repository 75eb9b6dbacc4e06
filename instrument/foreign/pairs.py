"""What can be read from other programs: Hadamard patterns and their complements, and the light of each."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from instrument.config import RunTable
from instrument.patterns import HadamardOrder, hadamard_order
from protocols import Floats, InputError, Integers, Mask

ORDERS: Final[tuple[HadamardOrder, ...]] = (
    "natural",
    "sequency",
    "tv",
    "tv-isotropic",
    "hyperbolic",
    "cake-cutting",
    "zig-zag",
)
"""Orders of patterns that need no seed."""


@dataclass(frozen=True, eq=False)
class HadamardPairs:
    """A measurement of an object at rest by Hadamard patterns, each with its complement."""

    image_size: int
    """Image pixels a side (m)."""

    pairs: Integers
    """``(n, 2)``: Walsh rows (c_i down, c_j across) of each pattern, in the order in which they were shown."""

    values: Floats
    """``(n, 2)``: light of each pattern and of its complement."""

    picture_time_s: float | None
    """Time from one pattern to the next; None where the file does not tell."""

    about: RunTable
    """What the file tells people."""

    missing: tuple[str, ...]
    """What a recording of ours would have and the file does not, in sentences."""

    origin: Mapping[str, str]
    """Where it comes from, for the recording."""


def side_of(patterns: int) -> int | None:
    """Image pixels a side of that many Hadamard patterns; None where it is no square of a power of two, 8 or more."""
    side = math.isqrt(patterns)
    return side if side * side == patterns and side >= 8 and not side & (side - 1) else None


def in_an_order(found: HadamardPairs) -> tuple[HadamardOrder | None, Integers]:
    """Find the order of ours in which the patterns were shown.

    Returns:
        Its name, and the frame of each pattern in it. None as the name where it is no order of ours; the frames are those of
        ``tv`` then.

    Raises:
        InputError: a pattern that does not exist.
    """
    size = found.image_size
    if len(found.pairs) and (found.pairs.min() < 0 or found.pairs.max() >= size):
        raise InputError(
            saw=f"a pattern of {int(found.pairs.max())} sign changes in {size} x {size} px",
            expected=f"0 to {size - 1}",
            remedy="look whether the file and its metadata belong together",
        )
    for order in ORDERS:
        if np.array_equal(hadamard_order(size, order)[: len(found.pairs)], found.pairs):
            return order, np.arange(len(found.pairs))
    place = np.empty((size, size), np.int64)
    ours = hadamard_order(size, "tv")
    place[ours[:, 0], ours[:, 1]] = np.arange(size * size)
    return None, place[found.pairs[:, 0], found.pairs[:, 1]]


def by_frame(frames: Integers, values: Floats) -> tuple[Floats, Mask]:
    """``(n, 2)`` and ``(n,)``: values at their frames, the mean where a pattern was shown twice; NaN and False where none was."""
    count = int(frames.max()) + 1 if len(frames) else 0
    shown = np.bincount(frames, minlength=count)
    sums = np.stack([np.bincount(frames, weights=column, minlength=count) for column in values.T], axis=1)
    measured = shown > 0
    placed = np.full((count, values.shape[1]), np.nan)
    placed[measured] = sums[measured] / shown[measured, None]
    return placed, np.asarray(measured & np.isfinite(placed).all(axis=1))
