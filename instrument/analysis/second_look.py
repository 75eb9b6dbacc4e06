"""A second look at slips, once path and image are known.

The counts alone tell of a slip by levels and by the order of the values, and of few photons they tell little: a slip is taken
for one by another number of patterns, values after it are left as not sure, or it passes unseen. Path and image tell far more, as
they expect every value. Nothing is looked at in a run of which the counts are sure and whose path and image agree.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Final, TypeAlias, TypeVar

import numpy as np

from instrument.analysis.find import NOTHING, Found
from instrument.joint import Explained, Placed, likeliest, placed
from instrument.measurement import Change, Measurement, Slips, suspects_of_counts

Find: TypeAlias = Callable[[Measurement], Found]
"""Function that finds path and image."""

Screen: TypeAlias = Callable[[Slips], Measurement]
"""Function that gives the run whose values came by some shifts."""

Answer = TypeVar("Answer")

_EXPLAINS: Final = 1.1
"""Cost over the number of values up to which path and image explain a run: of right ones it was 0.86 to 1.04 at 50 counts of an
all-on pattern."""

_FAR_BETTER: Final = 200.0
"""Cost by which they then explain it better: of right ones it was 450 to 28,000 there."""

_REACH: Final = 12
"""Frames to both sides of a change, told by the counts, among which it is looked for."""

_UNSURE: Final = 12
"""Frames not sure beside each change above which the counts do not tell the shift for sure."""


def surely_slipped(measurement: Measurement, screen: Screen) -> Measurement:
    """Give the run with the shifts that are likeliest, where the counts told that values slipped but not surely by how much."""
    slips = measurement.slips
    if slips is None or not slips.any:
        return measurement
    if np.count_nonzero(~slips.sure) <= _UNSURE * max(len(slips.changes), 1):
        return measurement
    best = _likeliest(measurement, screen)
    if best is None or best.cost > _EXPLAINS * measurement.values.size:
        return measurement
    return screen(best.slips)


def in_step_first(
    measurement: Measurement, ask: Callable[[Measurement], Answer], screen: Screen
) -> tuple[Measurement, Answer]:
    """Ask something of a run, and where it refuses to say, see first whether its values slipped.

    Args:
        measurement: of the run.
        ask: function that asks.
        screen: function that gives the run whose values came by some shifts.

    Returns:
        The run that was asked, and what it said.

    Raises:
        InputError, LinAlgError: the run refuses, and no slip explains it.
    """
    try:
        return measurement, ask(measurement)
    except NOTHING:
        slipped = slipped_for_sure(measurement, screen)
        if slipped is None:
            raise
    return slipped, ask(slipped)


def slipped_for_sure(measurement: Measurement, screen: Screen) -> Measurement | None:
    """Give the run with the shifts that are likeliest, where path and image then explain it, and far better; else None."""
    slipped, sure = slipped_unseen(measurement, screen)
    return slipped if sure else None


def slipped_unseen(measurement: Measurement, screen: Screen) -> tuple[Measurement | None, bool]:
    """Give the run with the shifts that are likeliest, where they explain it far better than none.

    Returns:
        The run, None where no slip does; and whether path and image then explain all of it.
    """
    best = _likeliest(measurement, screen)
    if best is None or not best.slips.any or best.gain < _FAR_BETTER:
        return None, False
    return screen(best.slips), best.cost <= _EXPLAINS * measurement.values.size


def _likeliest(measurement: Measurement, screen: Screen) -> Placed | None:
    """Give the likeliest shifts; None where nobody asked the counts."""
    slips = measurement.slips
    return None if slips is None else likeliest(len(slips.sure), screen, _suspects(slips, screen))


def placed_again(measurement: Measurement, found: Found, find: Find, screen: Screen) -> tuple[Measurement, Found]:
    """Place the changes of the shift by the path and the image that were found, and find both again where that makes a change."""
    slips, path, image = measurement.slips, found.trajectory, found.reconstruction
    if slips is None or not slips.changes or path is None or image is None:
        return measurement, found
    if screen(slips).findings != measurement.findings:  # it was taken otherwise in another way too
        return measurement, found
    raw = screen(Slips.none(len(measurement)))
    per_frame = raw.values.shape[1]
    if any(2 * abs(part.shift) == per_frame and part.within is None for part in slips.segments):
        return measurement, found  # those frames are masked, and the path knows none of them
    better = placed(raw, slips, Explained.of(found.measurement, path, image)).slips
    moved = [new.place - old.place for new, old in zip(better.changes, slips.changes, strict=True)]
    if max(np.abs(moved)) > _REACH * per_frame:
        return measurement, found
    if (
        not any(moved) and better.sure[slips.sure].all()
    ):  # as many frames as are known, but for a few beside the changes
        return measurement, found
    if better.changes[-1].place >= raw.values.size - per_frame:  # nothing comes after it that could tell
        better = Slips.changing((len(raw), per_frame), better.segments[0].shift, better.changes[:-1])
    again = screen(better)
    try:
        return again, find(again)
    except NOTHING:
        return measurement, found


def _suspects(told: Slips, screen: Screen) -> Iterator[Slips]:
    """Give the shifts that a run may have beside none: those that the counts told, or what one change may have been."""
    raw = screen(Slips.none(len(told.sure)))
    frames, per_frame = raw.values.shape
    if told.any:
        ways = [(told.segments[0].shift, told.changes), *_by_other_patterns(told, per_frame // 2)]
    else:
        counted = suspects_of_counts(raw.arrived, raw.valid, raw.scheme, photon_counts=raw.photon_counts)
        ways = [(0, (change,)) for change in counted]
    for first_shift, changes in ways:
        yield Slips.changing((frames, per_frame), first_shift, _widened(changes, per_frame))


def _by_other_patterns(told: Slips, most: int) -> Iterator[tuple[int, tuple[Change, ...]]]:
    """Give the shifts of a run in which one change is by another number of patterns: the place is told far more surely."""
    start, changes = told.segments[0].shift, told.changes
    for k, change in enumerate(changes):
        for shift in range(-most, most + 1):
            tried = [*changes[:k], replace(change, shift=shift), *changes[k + 1 :]]
            before = [start, *(one.shift for one in tried)]
            if shift != change.shift:
                yield start, tuple(one for one, last in zip(tried, before, strict=False) if one.shift != last)


def _widened(changes: Iterable[Change], per_frame: int) -> list[Change]:
    """Take changes to be anywhere within reach."""
    reach = _REACH * per_frame
    return [replace(change, first=max(change.place - reach, 1), last=change.place + reach) for change in changes]
