"""Dithering, which makes grey patterns binary."""

import numpy as np

from protocols import Bytes, Floats


def floyd_steinberg(grey: Floats) -> Bytes:
    """Make a grey pattern binary by error diffusion, row by row from the left.

    The error of each sample is passed to its right (7/16), lower left (3/16), lower (5/16) and lower right (1/16) neighbour.

    Args:
        grey: ``(rows, columns)`` grey values, 0 to 1.

    Returns:
        The binary pattern, ``(rows, columns)`` of 0 and 1.

    References:
        R. W. Floyd, L. Steinberg, "An adaptive algorithm for spatial grey scale", Proc. SID 17 (1976) 75-77.
    """
    rows, columns = grey.shape
    # One spare column on each side takes the error that leaves the pattern. Plain lists are faster to index than arrays.
    below = [0.0] * (columns + 2)
    binary = np.zeros((rows, columns), np.uint8)
    for row in range(rows):
        current, below = below, [0.0] * (columns + 2)
        line: list[float] = grey[row].tolist()
        lit: list[int] = []
        carried = 0.0
        for column in range(columns):
            value = line[column] + current[column + 1] + carried
            bit = 1 if value >= 0.5 else 0
            error = (value - bit) / 16
            carried = 7 * error
            below[column] += 3 * error
            below[column + 1] += 5 * error
            below[column + 2] += error
            lit.append(bit)
        binary[row] = lit
    return binary
