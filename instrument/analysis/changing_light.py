"""Light that rises in the first frames of a run, or falls in its last: means of it, and where it is steady.

The run is cut into twenty parts. A fall that takes a part or longer is seen in means over a part: in a run of 0.4 s or more that
averages the flicker of the mains away. A fall within the last part would be averaged away too. It is looked for in shorter means,
and must exceed by far the scatter of such means earlier in the run, which is large where a lamp flickers. A rise is a fall of the
run played backwards.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from instrument.numerics import step_noise
from protocols import Floats, Mask

_PARTS: Final = 20
"""Parts into which a run is cut. The total light is averaged over the length of one."""

_SHORTER: Final = 4
"""Length of a part over that of the means in which a fall within the last part is looked for."""

_SHORTEST: Final = 8
"""Fewest frames of these shorter means."""

_FALLEN: Final = 0.015
"""Share of the steady light that must be missing."""

_SIGMAS: Final = 4.0
"""Standard deviations of a mean over a part that the missing light must exceed."""

_SURE: Final = 6.0
"""Standard deviations of the shorter means, by their scatter earlier in the run, that the missing light must exceed."""

_DRIFTS: Final = 0.05
"""Share by which the light may exceed its steady level before it falls: that of a lamp which always fades exceeds it by more."""


@dataclass(frozen=True, eq=False)
class Change:
    """Light that falls to the end of a run, or rises from its beginning."""

    light: Floats
    """``(frames,)``: mean light around each frame, over the steady light."""

    half: int
    """Number of frames before a frame, and after it, over which its mean is taken."""

    frames: slice
    """Frames in which the light is not steady: all from one frame on, or all before one."""


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
    """``(frames,)``: means of the total light of the valid frames up to ``half`` away from each frame.

    Where there is none, the mean is that of the frames beside: what was not measured has not changed.
    """
    frames = len(total)
    sums = np.concatenate(
        [np.zeros((2, 1)), np.cumsum([np.where(valid, total, 0.0), valid.astype(np.float64)], axis=1)], axis=1
    )
    low, high = np.maximum(np.arange(frames) - half, 0), np.minimum(np.arange(frames) + half + 1, frames)
    light, count = sums[:, high] - sums[:, low]
    known = np.flatnonzero(count)
    if not len(known):
        return np.zeros(frames)
    return np.asarray(np.interp(np.arange(frames), known, light[known] / count[known]), np.float64)


def _long_fall(total: Floats, valid: Mask) -> Change | None:
    """Find a fall that takes more than a part of the run."""
    half = max(len(total) // _PARTS // 2, 1)
    if np.count_nonzero(valid) < 2:
        return None
    trend = means(total, valid, half)
    allowed = _SIGMAS * step_noise(total[valid]) / (2 * half + 1) ** 0.5
    steady = float(np.quantile(trend, 0.8))
    last = int(np.flatnonzero(trend >= steady - max(_FALLEN * steady, allowed))[-1]) - half
    if steady <= 0 or last < 1 or last > len(trend) - 2 * half:
        return None
    if float(trend[:last].max()) > steady + max(_DRIFTS * steady, allowed):
        return None  # it falls from the beginning on, as the light of a lamp that fades
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
