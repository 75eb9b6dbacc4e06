"""Small sequences whose mirrors are easy to tell apart."""

import numpy as np

from protocols import ModulatorTiming, PatternSequence, PixelGrid

TIMING = ModulatorTiming(picture_time_us=50)


def sequence(unique: int = 3, order: list[int] | None = None) -> PatternSequence:
    """``unique`` planes of 16 x 16 samples, one mirror each: plane k shows the number k in its first row, plane 0 is dark."""
    planes = np.zeros((unique, 16, 2), np.uint8)
    numbers = np.arange(unique)
    planes[:, 0, 0], planes[:, 0, 1] = numbers >> 8, numbers & 0xFF
    played = [*range(1, unique), 0] if order is None else order
    return PatternSequence(planes, np.array(played), PixelGrid(image_size=16, superpixel=1), samples=16)


def number_shown(plane: bytes) -> int:
    """The number that a plane of 1024 x 768 mirrors shows: the field's first row is 376, its first byte 63."""
    start = 376 * 128 + 63
    return int.from_bytes(plane[start : start + 2], "big")
