"""Whether a run shows what lies between the pixels of the patterns."""

from typing import Final

import numpy as np

from instrument.tracking import Trajectory

_PLACES: Final = 4
"""Parts of a pixel that the motion is to visit along each axis."""

_FEWEST: Final = 16
"""Frames that it is to spend in each."""

_NOISE: Final = 0.4
"""Penalty of total variation, over the typical transmission, from which on the noise hides what a finer grid would show."""


def grid_of(trajectory: Trajectory, penalty: float = 0.0) -> int:
    """Give the number of image pixels a pattern pixel that a run supports, 1 or 2.

    The object is seen on a grid that is finer by 2 where the patterns pass over it in steps of a fraction of a pixel: where
    every quarter of a pixel is visited, along both axes, in 16 frames or more; and where the noise is not too strong.

    Args:
        trajectory: path of the object.
        penalty: how strong the noise is, as ``TvState.penalty`` says.
    """
    place_px = trajectory.displacement_px[trajectory.valid]
    part = np.floor((place_px % 1) * _PLACES).astype(np.int64) % _PLACES
    visits = [np.bincount(part[:, axis], minlength=_PLACES) for axis in range(2)]
    return 2 if penalty < _NOISE and min(int(count.min()) for count in visits) >= _FEWEST else 1
