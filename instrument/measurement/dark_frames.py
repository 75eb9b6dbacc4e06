"""Frames without light: a shutter, a lamp that was off, or an object that is not there and lets none through.

Such frames tell nothing of the patterns. Their noise must not be taken for values that slipped to other patterns, nor be divided
by their light. A lamp that flickers is dark for fewer frames than are looked at. One that fades is dark when less than a fiftieth
of its light is left.
"""

from typing import Final

import numpy as np

from instrument.numerics import step_noise
from protocols import Floats, Mask

_FRAMES: Final = 9
"""Frames in a row whose mean light is looked at."""

_DARK: Final = 0.02
"""Mean light over that of bright frames, below which these frames are dark."""

_DIM: Final = 0.1
"""Mean light over that of bright frames that must be told from ``_DARK``, so that dim frames are not taken for dark ones."""

_SURE: Final = 4.0
"""Standard deviations by which both must differ. Where photons are too few for that, no frame is called dark."""


def dark_frames(total: Floats, *, photon_counts: bool) -> Mask:
    """``(frames,)``: whether a frame is dark, or beside dark ones, whose first and last may be lit in part.

    Args:
        total: ``(frames,)`` total light; NaN where it is not known.
        photon_counts: whether it counts photons, whose noise falls with the light.
    """
    known = np.isfinite(total)
    if np.count_nonzero(known) < 2 * _FRAMES:
        return np.zeros(len(total), bool)
    window = np.ones(_FRAMES)
    count = np.convolve(known.astype(np.float64), window, "valid")
    mean = np.convolve(np.where(known, total, 0.0), window, "valid") / np.maximum(count, 1.0)
    bright = float(np.quantile(mean[count > 0], 0.95))
    lit = total[known & (total > bright / 2)]
    when_dim = step_noise(lit) * (_DIM**0.5 if photon_counts else 1.0) / _FRAMES**0.5
    if not (_DIM - _DARK) * bright > _SURE * when_dim:
        return np.zeros(len(total), bool)
    within = (mean < _DARK * bright) & (count > _FRAMES / 2)
    return np.asarray(np.convolve(within, np.ones(_FRAMES + 2))[1:-1] > 0, bool)
