"""Noise of series in which some values are far off."""

from typing import Final

import numpy as np

from protocols import Floats

_MEDIAN: Final = 0.6745
"""Median of the absolute value of a normal deviate of standard deviation 1."""


def step_noise(series: Floats) -> float:
    """Standard deviation of the noise of a series, by the median of its steps; infinite where it has none.

    A step has twice the variance of a value. What changes slowly does not count, nor do a few values that are far off.

    Args:
        series: ``(n,)``.
    """
    steps = np.abs(np.diff(series))
    return float(np.median(steps)) / (_MEDIAN * 2**0.5) if len(steps) else np.inf
