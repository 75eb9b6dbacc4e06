"""Light that rises in the first frames of a run, or falls in its last: means of it, and where it is steady.

A fall that takes a part of the run or more is seen in means over a part, which is longer than a period of the mains. A later one
would be averaged away there: it is looked for in shorter means, held against their own scatter before, so that a lamp which
flickers counts for nothing. A rise is a fall of the run from its end.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from protocols import Floats, Mask

_PARTS: Final = 20
"""Parts of a run over one of which the total light is averaged: more than a period of the mains."""

_SHORTER: Final = 4
"""How much shorter the times are over which a fall in the last part is looked for."""

_SHORTEST: Final = 8
"""Frames that they have at least."""

_FALLEN: Final = 0.015
"""Share of the light that must be missing."""

_SIGMAS: Final = 4.0
"""Standard deviations of a mean by which it must be."""

_SURE: Final = 6.0
"""Scatter of the means before by which the light must fall in the last part."""

_DRIFTS: Final = 0.05
"""Share by which the light may fall before."""


@dataclass(frozen=True, eq=False)
class Change:
    """Light that falls to the end of a run, or rises from its beginning."""

    light: Floats
    """``(frames,)``: means around each frame, over the steady light."""

    half: int
    """Frames before and after that each of these means reaches."""

    frames: slice
    """Frames in which the light is not steady: those from one on, or those before one."""


def fall_of(total: Floats, valid: Mask) -> Change | None:
    """Find light that falls to the end of a run; None where it does not.

    Args:
        total: ``(frames,)`` total light.
        valid: ``(frames,)`` that were measured well.
    """
    return _long_fall(total, valid) or _late_fall(total, valid)


def rise_of(total: Floats, valid: Mask) -> Change | None:
    """Find light that rises from the beginning of a run on; None where it does not. As ``fall_of``."""
    backwards = fall_of(total[::-1], valid[::-1])
    if backwards is None:
        return None
    return replace(backwards, light=backwards.light[::-1], frames=slice(0, len(total) - backwards.frames.start))


def means(total: Floats, valid: Mask, half: int) -> Floats:
    """``(frames,)``: means of the total light of the valid frames up to ``half`` away from each frame."""
    frames = len(total)
    sums = np.concatenate(
        [np.zeros((2, 1)), np.cumsum([np.where(valid, total, 0.0), valid.astype(np.float64)], axis=1)], axis=1
    )
    low, high = np.maximum(np.arange(frames) - half, 0), np.minimum(np.arange(frames) + half + 1, frames)
    light, count = sums[:, high] - sums[:, low]
    return np.asarray(light / np.maximum(count, 1.0), np.float64)


def _long_fall(total: Floats, valid: Mask) -> Change | None:
    """Find a fall that takes more than a part of the run."""
    half = max(len(total) // _PARTS // 2, 1)
    trend, known = means(total, valid, half), total[valid]
    noise = float(np.median(np.abs(np.diff(known)))) / (0.6745 * 2**0.5) if len(known) > 1 else 0.0
    allowed = _SIGMAS * noise / (2 * half + 1) ** 0.5
    steady = float(np.quantile(trend, 0.8))
    last = int(np.flatnonzero(trend >= steady - max(_FALLEN * steady, allowed))[-1]) - half
    if steady <= 0 or last < 1 or last > len(trend) - 2 * half:
        return None
    if float(trend[:last].max()) > steady + max(_DRIFTS * steady, allowed):
        return None  # it fell from the beginning on, as that of a lamp
    return Change(trend / steady, half, slice(last, len(total)))


def _late_fall(total: Floats, valid: Mask) -> Change | None:
    """Find a fall in the last part of the run."""
    half = max(len(total) // _PARTS // _SHORTER, _SHORTEST) // 2
    trend = means(total, valid, half)
    before = trend[: -max(len(total) // _PARTS, 1)]
    steady = float(np.median(before)) if len(before) else 0.0
    scatter = 1.4826 * float(np.median(np.abs(before - steady))) if len(before) else 0.0
    bright = np.flatnonzero(trend >= steady - max(_FALLEN * steady, _SURE * scatter))
    if steady <= 0 or bright[-1] < half or bright[-1] > len(trend) - half:
        return None
    return Change(trend / steady, half, slice(int(bright[-1]) - half, len(total)))
