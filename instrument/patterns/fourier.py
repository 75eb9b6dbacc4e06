"""Fourier patterns: cosine fringes of one spatial frequency along one axis."""

from functools import lru_cache
from typing import Literal

import numpy as np

from instrument.patterns.dither import floyd_steinberg
from protocols import Bytes, Floats


def fringe(size: int, cycles: int, phase_rad: float, axis: Literal["x", "y"], upsampling: int = 1) -> Floats:
    """Give P(x, y) = 1/2 + 1/2 cos(2 pi f u + phase), where u is the pixel coordinate along ``axis`` and f = cycles / size.

    Args:
        size: image pixels a side (m).
        cycles: number of periods across the field.
        phase_rad: phase at pixel 0.
        axis: ``x`` for a fringe that varies along columns, ``y`` for one that varies along rows.
        upsampling: samples a side of one pixel, centred symmetrically about the centre of the pixel.

    Returns:
        Grey values from 0 to 1, ``(size * upsampling, size * upsampling)``, row = y.

    References:
        Li et al., "Single-pixel imaging of a translational object", Opt. Express (2023), equation 1.
    """
    coordinate_px = (np.arange(size * upsampling) + 0.5) / upsampling - 0.5
    line = 0.5 + 0.5 * np.cos(2 * np.pi * cycles / size * coordinate_px + phase_rad)
    square = np.broadcast_to(line, (len(line), len(line)))
    return np.array(square if axis == "x" else square.T)


@lru_cache(maxsize=32)
def fourier_pattern(size: int, cycles: int, phase_rad: float, axis: Literal["x", "y"], upsampling: int = 1) -> Bytes:
    """Give the binary pattern that represents ``fringe``, by Floyd-Steinberg dithering.

    Its complement, ``1 - pattern``, represents the fringe whose phase is larger by pi, so that both add to the all-one pattern
    exactly. The array is made once, kept, and read-only.
    """
    pattern = floyd_steinberg(fringe(size, cycles, phase_rad, axis, upsampling))
    pattern.flags.writeable = False
    return pattern
