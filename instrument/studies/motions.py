"""How the object moves in the studies: the motions of the paper's simulation and of its experiment."""

from collections.abc import Callable
from typing import Final, TypeAlias

import numpy as np

from protocols import Floats

PathOfTime: TypeAlias = Callable[[Floats], Floats]
"""Seconds ``(n,)`` after the first pattern to displacement ``(n, 2)``, x and y in px."""

PX_PER_MM: Final = 7.2
"""Image scale. The paper's stage goes 18.75 mm along the diagonal in half a second; so its letter of 3.2 mm stays in 128 px."""

_CIRCLE_PX: Final = 30.0


def curve(run_s: float) -> PathOfTime:
    """Motion I: a gentle S, 66 px across and 64 px down in ``run_s``. The paper prints none: a smooth curve of such a length."""

    def path(time_s: Floats) -> Floats:
        u = time_s / run_s
        return np.stack([66 * u + 4 * np.sin(2 * np.pi * u), 6.4 * u + 57.6 * (3 * u**2 - 2 * u**3)], axis=1)

    return path


def accelerated(run_s: float) -> PathOfTime:
    """Motion II: along the diagonal by v0 t + a t^2 / 2 in the ratio of 25 mm/s and 50 mm/s^2, 66 px each way in ``run_s``."""

    def path(time_s: Floats) -> Floats:
        u = time_s / run_s
        way = 66 * (2 * u / 3 + u**2 / 3)
        return np.stack([way, way], axis=1)

    return path


def along_diagonal(velocity_mm_s: float, acceleration_mm_s2: float = 0.0) -> PathOfTime:
    """Give the motion of the paper's stage, along the diagonal of the image."""

    def path(time_s: Floats) -> Floats:
        way_px = PX_PER_MM / np.sqrt(2) * (velocity_mm_s * time_s + acceleration_mm_s2 * time_s**2 / 2)
        return np.stack([way_px, way_px], axis=1)

    return path


def circle(velocity_mm_s: float) -> PathOfTime:
    """Go round a circle of 30 px radius at a constant speed: the only way to be fast for half a second inside the field."""

    def path(time_s: Floats) -> Floats:
        angle = velocity_mm_s * PX_PER_MM / _CIRCLE_PX * time_s
        turned: Floats = _CIRCLE_PX * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=1)
        return turned

    return path
