"""Slips: from which pattern on the values belong to the pattern before, or after.

A lost sync edge joins two bins, a surplus one splits a bin, and all values after it come one pattern early or late. In step, the
values of the position patterns change little from one frame to the next, and so does the sum of a pattern and its complement,
while their difference changes much. That tells the shift of a run, and levels that no longer go on tell where it changes.

For each shift s of -3 .. +3 patterns, a frame that follows another one costs minus twice the log-likelihood of the changes: their
squares over the variance that noise gives them, that of the difference over its own larger variance. Where the shift changes
values are split and joined, so that frames there are passed over, and the ones before and after are compared. The shifts of
all frames are those of the least total cost, found exactly (Viterbi); a shift is sure where all others cost far more.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from instrument.measurement.cheapest_shifts import cheapest_shifts
from protocols import Floats, Integers, Mask

_CHANGE: Final = 75.0
"""Cost of a change of the shift by one pattern, and of a start with one."""

_ONE_MORE: Final = 40.0
"""Cost of each change in a run in which there is one: that they come together is likelier than that there is one."""

_SURE: Final = 15.0
"""Cost by which any other shift is worse where a shift is sure."""

_MOST_SHIFT: Final = 3

_BLOCK: Final = 64
"""Frames in which noise and motion are taken to be alike."""

_WINDOW: Final = 31
"""Frames over which levels, and the changes of the difference, are averaged."""

_STEADY: Final = 5
"""Frames of whose changes the median is taken."""

_PLAIN: Final = 2.5
"""Variance of the difference, over that of noise, below which it says nothing: the largest of seven averages of noise."""

_EVEN: Final = 0.01
"""Standard deviation at least, over the value: no light of a bench is more even than that."""

_THIRD: Final = 0.6745
"""Absolute value of a normal deviate that one in two lies below, as one in three of all does where a third changes much."""

_PROPORTIONAL: Final = 30.0
"""Sum of squares that noise leaves at most of a frame that is as its neighbours, but for its brightness."""

_FEW: Final = 8
"""Frames that may go with no neighbour, as a fault makes them. More are a flaw of the bench's light, or rough motion."""

FEWEST_FRAMES: Final = 6
"""Whole frames below which values cannot tell whether they slipped."""

_FEWEST_COUNTS: Final = 10.0
"""Counts of a pair below which photons are too few to tell."""


@dataclass(frozen=True)
class Segment:
    """Successive frames with the same shift."""

    first_frame: int
    """First frame."""

    end_frame: int
    """Frame after the last one."""

    shift: int
    """Patterns by which the values come late; negative: early."""


@dataclass(frozen=True, eq=False)
class Slips:
    """The shifts of a run."""

    segments: tuple[Segment, ...]
    """All frames, in order; one segment of shift 0 where nothing slipped."""

    sure: Mask
    """``(frames,)``: whether the frame goes with its neighbours, its shift is known, and no change of it is near."""

    @classmethod
    def none(cls, frames: int) -> "Slips":
        """Every value in its place."""
        return cls((Segment(0, frames, 0),), np.full(frames, True))

    @property
    def shift(self) -> Integers:
        """``(frames,)``: patterns by which the values of each frame come late."""
        return np.repeat([s.shift for s in self.segments], [s.end_frame - s.first_frame for s in self.segments])

    @property
    def any(self) -> bool:
        """Whether any value slipped."""
        return any(segment.shift for segment in self.segments)


def slips_of(light: Floats, variance: Floats, pair: tuple[int, int] | None) -> Slips:
    """Find the shifts of all frames.

    Args:
        light: ``(frames, patterns_per_frame)`` in play order; NaN where no value was measured.
        variance: ``(patterns_per_frame,)`` for noise that does not depend on the light; for photon counts all 0.
        pair: columns of a pattern and its complement, side by side; without them nothing is found.
    """
    frames, per_frame = light.shape
    in_step = Slips.none(frames)
    if pair is None or pair[1] != pair[0] + 1 or frames < FEWEST_FRAMES or not np.isfinite(light).any():
        return in_step
    total = light[:, pair[0]] + light[:, pair[1]]
    known = total[np.isfinite(total)]
    if not len(known) or (not variance.any() and np.median(known) < _FEWEST_COUNTS):
        return in_step
    most = min(_MOST_SHIFT, per_frame // 2)
    quiet, steady, power, loud, told = _series(light, variance, pair[0], most)
    if not told:
        return in_step
    shift, margin = cheapest_shifts(quiet, steady, power, loud, _CHANGE, margins=False)
    if shift.any():
        shift, margin = cheapest_shifts(quiet, steady, power, loud, _ONE_MORE, margins=True)
    else:
        margin[_only_lamp(quiet[:, most], power[:, most], margin == 0)] = np.inf
    starts = np.flatnonzero(np.diff(shift, prepend=shift[0] - 1))
    ends = np.append(starts[1:], frames)
    segments = tuple(Segment(int(a), int(b), int(shift[a])) for a, b in zip(starts, ends, strict=True))
    sure = margin > (_SURE if shift.any() else 0.0)
    if not shift.any() and np.count_nonzero(~sure) > _FEW:  # so many are the bench's own way
        sure[:] = True
    sure[1:-1] &= (margin[:-2] > 0) & (margin[2:] > 0)
    for start in starts[1:]:
        sure[max(0, start - 2) : start + 2] = False
    return Slips(segments, np.asarray(sure, bool))


def in_step_again(values: Floats, slips: Slips) -> Floats:
    """Move the values back to their own patterns, ``(frames, patterns_per_frame)``; NaN where the shift is not sure.

    A shift by half a frame is not moved back, as it may as well be one to the other side.
    """
    per_frame, shift = values.shape[1], slips.shift
    sure = slips.sure & (2 * np.abs(shift) < max(per_frame, 3))
    source = np.arange(values.size).reshape(values.shape) + shift[:, None]
    inside = (source >= 0) & (source < values.size)
    source = source.clip(0, values.size - 1)
    # A pattern's value lies in its own frame or in the next one, which must be sure of the same shift.
    other = source // per_frame
    good = inside & sure[:, None] & sure[other] & (shift[other] == shift[:, None])
    return np.where(good, values.ravel()[source], np.nan)


def _only_lamp(quiet: Floats, power: Floats, strange: Mask) -> Mask:
    """Whether a strange frame goes with its neighbours if it is made brighter or darker as a whole, as by the lamp."""
    lamp = np.zeros(len(quiet), bool)
    good = np.flatnonzero(~strange)
    for frame in np.flatnonzero(strange):
        beside = good[np.argsort(np.abs(good - frame))[:2]]
        if not len(beside):
            continue
        level = quiet[beside].mean(axis=0)
        scale = float(quiet[frame].sum() / level.sum()) if level.sum() > 0 else np.nan
        left = (quiet[frame] - scale * level) ** 2 / (2 * power[frame] * max(scale, 1.0) ** 2)
        lamp[frame] = bool(left.sum() < _PROPORTIONAL)
    return lamp


def _series(light: Floats, variance: Floats, first: int, most: int) -> tuple[Floats, Floats, Floats, Floats, bool]:
    """What each frame has if it is shifted by each number of patterns.

    Returns:
        ``(frames, shifts, m)`` values that change little from frame to frame: those of the single patterns, then the sum of the
        pair; their steady change from the frame before, which motion makes; their variances; and ``(frames, shifts)`` the
        squared change of the pair's difference over its variance. Last, whether any pair changes more than noise does.
    """
    frames, per_frame = light.shape
    steady = _steady_change(light)
    sigma2 = _noise(light, steady, variance)
    room = np.full(per_frame, np.nan)  # nothing is known of bins before the first frame and after the last one
    bins, slope, power = (np.concatenate([room, part.ravel(), room]) for part in (light, steady, sigma2))
    starts: Integers = per_frame * np.arange(1, frames + 1, dtype=np.int64)
    place: Integers = np.add.outer(starts, np.arange(-most, most + 1, dtype=np.int64))
    columns = np.array([column for column in range(per_frame) if column not in (first, first + 1)], np.int64)
    single = place[:, :, None] + columns
    one, two = place + first, place + first + 1

    def quiet(series: Floats) -> Floats:
        """The single patterns, and the sum of the pair."""
        return np.concatenate([series[single], (series[one] + series[two])[:, :, None]], axis=2)

    # What a pair's squares, each over its variance, have beyond that of the sum is that of the weighted difference.
    change = _jump(bins[one], slope[one]) / power[one] - _jump(bins[two], slope[two]) / power[two]
    loud = np.nan_to_num(change**2 / (2 / power[one] + 2 / power[two]), nan=1.0)
    spread = _means(np.minimum(loud, 1e6)).max(axis=1, keepdims=True)
    spread[spread < _PLAIN] = 1.0
    return quiet(bins), quiet(slope), quiet(power), loud / spread, bool((spread > 1).any())


def _jump(values: Floats, steady: Floats) -> Floats:
    """Change from the frame before, less the steady one."""
    return np.asarray(np.diff(values, axis=0, prepend=np.nan) - steady, np.float64)


def _steady_change(light: Floats) -> Floats:
    """Give the median over five frames of the change from the frame before, which no single value moves far.

    Where it is not known, as at the ends, it is that of the frames beside; 0 where it is known nowhere.
    """
    half = _STEADY // 2
    change = np.pad(np.diff(light, axis=0, prepend=np.nan), ((half, half), (0, 0)), constant_values=np.nan)
    around = np.sort([change[k : k + len(light)] for k in range(_STEADY)], axis=0)  # NaN comes last
    known: Mask = np.asarray(np.isfinite(around).all(axis=0), np.bool_)
    steady = np.where(known, around[half], 0.0)
    index = np.arange(len(light))
    for column in range(light.shape[1]):
        there = np.flatnonzero(known[:, column])
        if len(there):
            steady[:, column] = np.interp(index, there, steady[there, column])
    return steady


def _noise(light: Floats, steady: Floats, variance: Floats) -> Floats:
    """Variance of each value, as changes from frame to frame show it: motion and lamp enlarge it."""
    sigma2 = np.broadcast_to(variance, light.shape) if variance.any() else np.maximum(_means(light), 1.0)
    sigma2 = np.nan_to_num(np.maximum(sigma2, (_EVEN * _means(light)) ** 2), nan=1.0)
    sigma2 = np.maximum(sigma2, 1e-280)
    ratio = np.abs(_jump(light, steady)) / np.sqrt(2 * sigma2)
    blocks = max(1, len(light) // _BLOCK)
    scale = np.concatenate([np.full(len(part), _third(part)) for part in np.array_split(ratio, blocks)])
    return np.asarray(sigma2 * np.maximum(scale / _THIRD, 1.0)[:, None] ** 2, np.float64)


def _third(ratio: Floats) -> float:
    """Give what one in three lies below: two of three values are of patterns that are the same in all frames, and quiet."""
    known = ratio[np.isfinite(ratio)]
    return float(np.quantile(known, 1 / 3)) if len(known) else 0.0


def _means(values: Floats) -> Floats:
    """Running means over frames of the values that are numbers, fewer at the ends; NaN where there is none."""
    half = min(_WINDOW, len(values)) // 2
    known = np.isfinite(values)
    low = np.maximum(np.arange(len(values)) - half, 0)
    high = np.minimum(np.arange(len(values)) + half + 1, len(values))

    def sums(part: Floats) -> Floats:
        """Sums from the start, from which that of any window is a difference."""
        total = np.cumsum(np.pad(part, ((1, 0), (0, 0))), axis=0)
        return np.asarray(total[high] - total[low], np.float64)

    count = sums(known.astype(np.float64))
    return np.where(count > 0, sums(np.where(known, values, 0.0)) / np.maximum(count, 1.0), np.nan)
