"""From the mirrors of a plane to what the light sees of them: the image field alone, on the coarsest grid that loses nothing."""

import numpy as np

from protocols import Bytes, PixelGrid


def lit_samples(packed: Bytes, grid: PixelGrid, *, inverted: bool) -> Bytes:
    """``(samples, samples)`` of 0 and 1: superpixels where each is of one piece, single mirrors otherwise.

    With ``inverted`` mirrors the detector is lit by those that are off.
    """
    coarse = superpixels(packed, grid)
    lit = field_mirrors(packed, grid) if coarse is None else coarse
    return 1 - lit if inverted else lit


def superpixels(packed: Bytes, grid: PixelGrid) -> Bytes | None:
    """One mirror of each superpixel, ``(image_size, image_size)``; None where a superpixel is not of one piece.

    On the image grid the light is the same as on the mirrors, and it is found faster.
    """
    size, side = grid.superpixel, grid.side_mirrors
    field, left = _field(packed, grid)
    rows = field[::size]
    if not all((field[mirror::size] == rows).all() for mirror in range(1, size)):
        return None
    mirrors = np.unpackbits(rows, axis=1)[:, left : left + side]
    first = np.ascontiguousarray(mirrors[:, ::size])
    return first if all((mirrors[:, mirror::size] == first).all() for mirror in range(1, size)) else None


def field_mirrors(packed: Bytes, grid: PixelGrid) -> Bytes:
    """Cut the image field out of a packed mirror plane: ``(side_mirrors, side_mirrors)`` of 0 and 1."""
    field, left = _field(packed, grid)
    return np.unpackbits(field, axis=1)[:, left : left + grid.side_mirrors]


def _field(packed: Bytes, grid: PixelGrid) -> tuple[Bytes, int]:
    """The bytes that hold the field, and in which bit of the first of them it begins."""
    (top, left), side = grid.origin, grid.side_mirrors
    return packed[top : top + side, left // 8 : -(-(left + side) // 8)], left % 8
