"""Moment patterns: grey ramps along one axis, whose value over the total light is the object's centroid."""

from functools import lru_cache
from typing import Literal

import numpy as np

from instrument.patterns.dither import floyd_steinberg
from protocols import Bytes, Floats


def ramp(size: int, axis: Literal["x", "y"], upsampling: int = 1) -> Floats:
    """Give P(x, y) = (u + 1/2) / size, where u is the pixel coordinate along ``axis``.

    The ramp is 0 at the first border of the field and 1 at the last.

    Args:
        size: image pixels a side (m).
        axis: ``x`` for a ramp that grows along columns, ``y`` for one that grows along rows.
        upsampling: samples a side of one pixel.

    Returns:
        Grey values from 0 to 1, ``(size * upsampling, size * upsampling)``, row = y.

    References:
        Zha, Shi, Meng, Liu, Peng, Opt. Express 29(19) (2021) 30327: geometric moment patterns.
    """
    samples = size * upsampling
    line = (np.arange(samples) + 0.5) / samples
    square = np.broadcast_to(line, (samples, samples))
    return np.array(square if axis == "x" else square.T)


@lru_cache(maxsize=16)
def moment_pattern(size: int, axis: Literal["x", "y"], upsampling: int = 1) -> Bytes:
    """Give the binary pattern that represents ``ramp``, by Floyd-Steinberg dithering.

    The array is made once, kept, and read-only.
    """
    pattern = floyd_steinberg(ramp(size, axis, upsampling))
    pattern.flags.writeable = False
    return pattern
