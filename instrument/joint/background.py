"""Whether something stands still in the light, beside the object that moves."""

from typing import Final

import numpy as np

from instrument.measurement import Measurement
from instrument.numerics import TvState
from instrument.reconstruction import Problem, solved
from instrument.schemes import position_of

_OFFSET: Final = 0.01
"""Offset of a position pattern, over the total light, from which on a background is looked for: less costs less than to look."""

_MISFIT: Final = 1.1
"""Misfit of an image without background up to which none is needed: offsets are taken off, and the rest is less than noise."""

_BETTER: Final = 0.25
"""Relative fall of the squared misfit from which on a background is believed. One that is not there takes 0.05 to 0.17, of the
noise and of light that the object's image is too smooth for; one of a tenth of the object's light takes 0.4 at a noise of 0.1."""


def background_of(measurement: Measurement, problem: Problem) -> tuple[bool, TvState | None]:
    """Say whether a run shows a background that stands still.

    Its light moves the offsets of the position patterns, each by another amount. So does the light that patterns lose at their
    edges, but alike for all of them, and negatively. Where more than that is seen, images with and without a background are
    compared by what they leave unexplained.

    Args:
        measurement: measurement, with the offsets that were found.
        problem: image problem of the run without a background.

    Returns:
        Whether there is one, and the images of object and background with which the comparison was made, if any.
    """
    reading = position_of(measurement.scheme)
    offset = np.array([parameter.value for parameter in measurement.light.offsets])
    if reading.period_px is None or not len(offset):
        return False, None  # a centroid is that of all light together, and the path was found from it
    beyond_edges = float(np.abs(offset - min(float(offset.mean()), 0.0)).max())
    if all(parameter.sigma is not None for parameter in measurement.light.offsets) and beyond_edges < _OFFSET:
        return False, None
    alone = solved(problem, tolerance=0.03, iterations=40)
    if alone.misfit < _MISFIT:
        return False, alone
    converged = solved(problem, tolerance=0.01, iterations=200, start=alone)
    both = solved(problem.with_still(), tolerance=0.01, iterations=200)
    if both.misfit**2 < (1 - _BETTER) * converged.misfit**2:
        return True, both
    return False, converged
