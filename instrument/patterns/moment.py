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


def saddle(size: int, axes: Literal["squares", "product"], upsampling: int = 1) -> Floats:
    """Give a second-order moment pattern about the middle of the field, 0 at two ends of the field and 1 at the others.

    With u = x - (m - 1)/2 and v = y - (m - 1)/2 it is P = 1/2 + 2 (u^2 - v^2) / m^2 (``squares``) or P = 1/2 + 2 u v / m^2
    (``product``): the value over the total light is 1/2 plus 2 / m^2 times the mean of u^2 - v^2, or of u v.

    Args:
        size: image pixels a side of the field (m).
        axes: which of both.
        upsampling: samples a side of one pixel.

    Returns:
        Grey values from 0 to 1, ``(size * upsampling, size * upsampling)``, row = y.
    """
    samples = size * upsampling
    line = ((np.arange(samples) + 0.5) / samples - 0.5) ** (2 if axes == "squares" else 1)
    v, u = line[:, None], line[None, :]
    return np.asarray(0.5 + 2 * (u - v if axes == "squares" else u * v), np.float64)


@lru_cache(maxsize=16)
def saddle_pattern(size: int, axes: Literal["squares", "product"], upsampling: int = 1) -> Bytes:
    """Give the binary pattern that represents ``saddle``, by Floyd-Steinberg dithering.

    The array is made once, kept, and read-only.
    """
    pattern = floyd_steinberg(saddle(size, axes, upsampling))
    pattern.flags.writeable = False
    return pattern
