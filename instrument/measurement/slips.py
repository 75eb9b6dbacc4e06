"""Slips: from which pattern on the values belong to the pattern before, or after.

A lost sync edge joins two bins, a surplus one splits a bin, and all values after it come one pattern early or late. Two things
tell. A pattern and its complement go up and down against each other, and no other two values of a frame do: where they stand
tells the shift of a frame by itself (``opposites``). And all levels go on where nothing changes (``levels``): at a slip each
column goes on where another one was, and those few shifts by which all of them do are the only ones that are likely.

For each shift s of -3 .. +3 patterns a frame costs minus twice the log-likelihood ratio of its pair. A change costs what one is
unlikely, and by how much levels do not go on; frames where the shift changes are passed over. To stay costs where all levels
jump. The shifts of all frames are those of the least total cost, found exactly (Viterbi); a shift is sure where all others cost
far more.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from instrument.measurement.change_places import change_place
from instrument.measurement.cheapest_shifts import cheapest_shifts
from instrument.measurement.levels import Levels
from instrument.measurement.opposites import noise_of, opposites
from instrument.measurement.slip_evidence import SlipEvidence
from protocols import Floats, Integers, Mask

_CHANGE: Final = 50.0
"""Cost of a change of the shift by one pattern, and of a start with one."""

_ONE_MORE: Final = 40.0
"""Cost of each change in a run in which there is one: that they come together is likelier than that there is one."""

_SURE: Final = 10.0
"""Cost by which any other shift is worse where a shift is sure."""

_JUMP: Final = 20.0
"""Sum of squares from which on levels jump; that of six levels in noise is 6, and 30 once in 20,000 frames."""

_MOST_JUMP: Final = 120.0
"""Cost at most where levels jump: so unlikely is it that the object does."""

_APART: Final = 10
"""Frames between two jumps: the frames of a line."""


@dataclass(frozen=True)
class Segment:
    """Successive frames with the same shift."""

    first_frame: int
    """First frame."""

    end_frame: int
    """Frame after the last one."""

    shift: int
    """Patterns by which the values come late; negative: early."""

    first_pattern: int = 0
    """First pattern whose value is not where it was before, as far as the values tell."""

    within: tuple[int, int] | None = None
    """The first and the last pattern that ``first_pattern`` may be; None where the range is not known."""


@dataclass(frozen=True)
class Change:
    """A place where the shift changes. Values are numbered as they came."""

    place: int
    """The first value that comes after it, most likely."""

    first: int
    """The first one that it may be."""

    last: int
    """The last one that it may be."""

    shift: int
    """Patterns by which values come late from there on."""


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

    @property
    def changes(self) -> "tuple[Change, ...]":
        """Where the shift changes, as far as the segments say."""
        after = zip(self.segments, self.segments[1:], strict=False)
        places = [(new.first_pattern + old.shift, new.shift) for old, new in after]
        return tuple(Change(place, place, place, shift) for place, shift in places)

    @classmethod
    def changing(cls, shape: tuple[int, int], start: int, changes: "Iterable[Change]") -> "Slips":
        """Give the shifts of a run that change at known places.

        Args:
            shape: number of frames, and of patterns of each.
            start: shift from the first frame on.
            changes: where the shift changes, in ascending order.

        Returns:
            The shifts; frames in which a value may be of another pattern are not sure.
        """
        frames, per_frame = shape
        sure = np.full(frames, True)
        segments = [Segment(0, frames, start)]
        for change in changes:
            old = segments.pop()
            # Frames before the one are of values before the change, frames from the other on of values after it.
            before = (change.first - old.shift) // per_frame
            after = -((change.shift - change.last) // per_frame)
            sure[max(before, 0) : max(after, 0)] = False
            first = min(max((change.place - old.shift) // per_frame, min(before, after)), max(before, after))
            first = min(max(first, old.first_frame + 1), frames - 1)
            segments.append(replace(old, end_frame=first))
            within = change.first - old.shift, change.last - old.shift
            segments.append(Segment(first, frames, change.shift, change.place - old.shift, within))
        return cls(tuple(segments), sure)


def slips_of(light: Floats, wild: Mask, variance: Floats, pair: tuple[int, int] | None) -> Slips:
    """Find the shifts of all frames.

    Args:
        light: ``(frames, patterns_per_frame)`` in play order; NaN where no value was measured.
        wild: likewise, whether a value goes with none before and after it: that tells nothing, unless one beside is its opposite.
        variance: ``(patterns_per_frame,)`` for noise that does not depend on the light; for photon counts all 0.
        pair: columns of a pattern and its complement, side by side; without them nothing is found.
    """
    frames, per_frame = light.shape
    evidence = SlipEvidence.of(light, wild, variance, pair)
    if pair is None or evidence is None:
        return Slips.none(frames)
    known, strange, sigma2, levels, most = (
        evidence.light,
        evidence.strange,
        evidence.sigma2,
        evidence.levels,
        evidence.most,
    )
    pairs, of_column, has_levels = evidence.pairs, sigma2, evidence.has_levels
    shift, margin = cheapest_shifts(pairs, has_levels * _stays(levels.jumps()), levels, _CHANGE, margins=False)
    if shift.any():
        mended = _moved(known, shift)  # a change of the shift enlarges what deviations and lines seem to vary
        of_column = noise_of(mended, variance)
        columns: Integers = np.subtract.outer(-shift, -np.arange(per_frame, dtype=np.int64)) % per_frame
        sigma2 = np.take_along_axis(of_column, columns, axis=1)
        pairs, _ = opposites(known, sigma2, pair[0], most)
        levels = Levels.of(known, sigma2, Levels.of(mended, of_column).scale)
        shift, margin = cheapest_shifts(pairs, has_levels * _stays(levels.jumps()), levels, _ONE_MORE, margins=True)
    sure = (margin > _SURE) & ~strange
    starts = np.flatnonzero(np.diff(shift, prepend=shift[0] - 1)).tolist()
    segments: list[Segment] = []
    for start, end in zip(starts, [*starts[1:], frames], strict=True):
        first, place = start, start * per_frame
        if start:
            old = segments.pop()
            place, least, most_late = change_place(known, of_column, levels, start, (old.shift, int(shift[start])))
            first = min(max(place // per_frame, old.first_frame + 1), end - 1)
            sure[max(0, min(first, least // per_frame) - 1) : max(first, most_late // per_frame) + 2] = False
            place -= old.shift
            segments.append(replace(old, end_frame=first))
        elif shift[0]:
            sure[:2] = False
        segments.append(Segment(first, int(end), int(shift[start]), place))
    beside = np.pad(strange, 1)
    sure &= ~(beside[:-2] | beside[2:])
    return Slips(tuple(segments), np.asarray(sure, bool))


def in_step_again(values: Floats, slips: Slips) -> Floats:
    """Move the values back to their own patterns, ``(frames, patterns_per_frame)``; NaN where the shift is not sure.

    A shift by half a frame is not moved back unless its place was asked for, as it may as well be one to the other side.
    """
    per_frame = max(values.shape[1], 3)
    parts = [(2 * abs(part.shift) != per_frame or part.within is not None, part) for part in slips.segments]
    sides: Mask = np.repeat([known for known, _ in parts], [part.end_frame - part.first_frame for _, part in parts])
    return _moved(values, slips.shift, slips.sure & sides)


def moved_back(values: Floats, slips: Slips) -> Floats:
    """Move the values back as ``in_step_again`` does, also where that is not sure."""
    return _moved(values, slips.shift)


def _moved(values: Floats, shift: Integers, sure: Mask | None = None) -> Floats:
    """Move values by so many patterns; NaN where they are not sure, or come from a frame of another shift."""
    per_frame = values.shape[1]
    source = np.arange(values.size).reshape(values.shape) + shift[:, None]
    inside = (source >= 0) & (source < values.size)
    source = source.clip(0, values.size - 1)
    # A pattern's value lies in its own frame or in the next one, which must be sure of the same shift.
    other = source // per_frame
    good = inside & (shift[other] == shift[:, None])
    if sure is not None:
        good &= sure[:, None] & sure[other]
    return np.where(good, values.ravel()[source], np.nan)


def _stays(jumps: Floats) -> Floats:
    """Cost of going on where levels jump, once for each jump."""
    around = np.lib.stride_tricks.sliding_window_view(np.pad(jumps, _APART), 2 * _APART + 1).max(axis=1)
    peak = (jumps >= around) & (jumps > _JUMP)
    return np.where(peak, np.minimum(jumps - 6, _MOST_JUMP), 0.0)
