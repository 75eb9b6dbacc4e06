"""What the counts of a run show of slips: which values go against each other, and what their levels are."""

from dataclasses import dataclass
from typing import Final, Self

import numpy as np

from instrument.measurement.levels import Levels
from instrument.measurement.opposites import noise_of, opposed, opposites
from protocols import Floats, Mask

_MOST_SHIFT: Final = 3

_AROUND: Final = 9
"""Frames of whose values the median is taken, which a few strange ones do not move."""

_LAMP: Final = 5
"""Frames over whose total the lamp is averaged."""

_DARK: Final = 0.25
"""Share of the mean light below which a frame is dark."""

_FAR: Final = 25.0
"""Squared deviation, over the variance, beyond which a value is far off."""

_PROPORTIONAL: Final = 30.0
"""Sum of squares that noise leaves at most of a frame that is as its neighbours, but for its brightness."""

_FEW: Final = 8
"""Frames that may go with no neighbour, as a fault makes them. More are a flaw of the bench's light, or rough motion."""

FEWEST_FRAMES: Final = 16
"""Whole frames below which values cannot tell whether they slipped."""

_FEWEST_COUNTS: Final = 10.0
"""Counts of a pair below which photons are too few to tell."""


@dataclass(frozen=True, eq=False)
class SlipEvidence:
    """What tells where values stand, as they came. Arrays begin with ``frames``."""

    light: Floats
    """``(frames, patterns_per_frame)``: light as of a steady lamp; NaN where nothing is known, or a frame is strange."""

    strange: Mask
    """``(frames,)``: whether the frame goes with none of those around."""

    sigma2: Floats
    """``(frames, patterns_per_frame)``: variance of each value."""

    pairs: Floats
    """``(frames, 2 most + 1)``: what each shift costs, by where a pattern and its complement stand."""

    levels: Levels
    """Levels before and after each frame."""

    most: int
    """Patterns at most by which values are taken to come late or early."""

    @property
    def has_levels(self) -> bool:
        """Whether any pattern stays the same from frame to frame: of a pair alone none does."""
        return bool(self.light.shape[1] > 2)

    @classmethod
    def of(cls, light: Floats, wild: Mask, variance: Floats, pair: tuple[int, int] | None) -> Self | None:
        """Look at the light as ``slips_of`` gets it; None where it cannot tell anything."""
        frames, per_frame = light.shape
        if pair is None or pair[1] != pair[0] + 1 or frames < FEWEST_FRAMES or not np.isfinite(light).any():
            return None
        total = light[:, pair[0]] + light[:, pair[1]]
        known = total[np.isfinite(total)]
        if not len(known) or (not variance.any() and np.median(known) < _FEWEST_COUNTS):
            return None
        light = _steady(np.where(wild & ~opposed(light), np.nan, light))
        most = min(_MOST_SHIFT, per_frame // 2)
        sigma2 = noise_of(light, variance)
        strange = _strange(light, sigma2)
        pairs, told = opposites(light, sigma2, pair[0], most)
        if not told:
            return None
        light = np.where(strange[:, None], np.nan, light)
        return cls(light, strange, sigma2, pairs, Levels.of(light, sigma2), most)


def _steady(light: Floats) -> Floats:
    """Light as of a lamp that does not change: any six values in a row are of as many patterns, whether they slipped or not.

    Where there is hardly any, as when the object has left the field, nothing is known.
    """
    total = _filled(light).sum(axis=1)
    around = np.convolve(np.pad(total, _LAMP // 2, mode="edge"), np.full(_LAMP, 1 / _LAMP), "valid")
    mean = float(around.mean())
    lit = around > max(_DARK * mean, 0.0)
    return np.where(lit[:, None], light * (mean / np.where(lit, around, 1.0))[:, None], np.nan)


def _filled(light: Floats) -> Floats:
    """Light with values between those beside in place of each that is not known."""
    filled = np.nan_to_num(light)
    index = np.arange(len(light))
    for column in np.flatnonzero(~np.isfinite(light).all(axis=0)):
        known = np.isfinite(light[:, column])
        if known.any():
            filled[:, column] = np.interp(index, index[known], light[known, column])
    return filled


def _strange(light: Floats, sigma2: Floats) -> Mask:
    """``(frames,)``: whether several values of a frame are far from those around, and not by the lamp; none if they are many."""
    per_frame, filled = light.shape[1], _filled(light)
    half = _AROUND // 2
    padded = np.pad(filled, ((half, half), (0, 0)), mode="reflect")
    around = np.sort(np.lib.stride_tricks.sliding_window_view(padded, _AROUND, axis=0), axis=-1)[..., half]
    off2 = (filled - around) ** 2 / sigma2
    strange = np.count_nonzero((off2 > _FAR) & ~opposed(light), axis=1) > per_frame // 3
    for frame in np.flatnonzero(strange):
        scale = float(filled[frame].sum() / around[frame].sum()) if around[frame].sum() > 0 else 1.0
        left = (filled[frame] - scale * around[frame]) ** 2 / (sigma2[frame] * max(scale, 1.0) ** 2)
        strange[frame] = left.sum() > _PROPORTIONAL
    if np.count_nonzero(strange) > _FEW:
        strange[:] = False
    return np.asarray(strange, bool)
