"""Where the shift of a run changes, by the values that path and image expect.

Of few photons, levels and order of the values alone tell little of a slip. Path and image that are made of most frames expect the
values of all of them, so that each value as it came is asked how likely it is as one of the pattern before, its own, or the one
after. The place of a change is the one that makes all values likeliest. Where the shift itself is in doubt, that which makes them
likeliest is it.
"""

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from instrument.joint.expected import Explained, at_first_sight
from instrument.measurement import Change, Measurement, Slips, by_patterns, cheapest_place
from protocols import Floats, InputError, Integers

_LEAST: Final = 0.02
"""Variance at least, over the mean one."""

_MOST: Final = 30.0
"""Cost at most of one value: that in which two bins were joined says nothing."""

_AS_LIKELY: Final = 10.0
"""Cost by which a place is worse that is as good as ruled out: odds of 1 in 150."""

_LOOKS: Final = 3
"""Looks at most at the place of one change, each with the image that the last one gave."""


@dataclass(frozen=True, eq=False)
class Placed:
    """A run with the places where its shift changes."""

    slips: Slips
    """The shifts; frames in which a value may be of another pattern are not sure."""

    cost: float
    """Minus twice the logarithm of the likelihood of all values, and twice the numbers that the path took from them, as Akaike's
    criterion has it (IEEE Trans. Autom. Control 19 (1974) 716)."""

    gain: float = 0.0
    """By how much that is less than it were had nothing slipped; infinite where there is then no path."""


def placed(raw: Measurement, slips: Slips, explained: Explained) -> Placed:
    """Place the changes of the shift.

    Args:
        raw: of the run, its values where they came.
        slips: the shifts, and about where they change.
        explained: path and image of that run.
    """
    shape = raw.values.shape
    shifts = [segment.shift for segment in slips.segments]
    costs = _costs(raw, explained, np.unique(shifts))
    ends = [0, *(change.place for change in slips.changes), raw.values.size]
    changes: list[Change] = []
    for k, change in enumerate(slips.changes):
        low, high = ends[k], ends[k + 2]
        before, after = (costs[shift][low:high] for shift in shifts[k : k + 2])
        place, first, last = cheapest_place(before, after, _AS_LIKELY)
        changes.append(Change(low + place, low + first, low + last, change.shift))
        ends[k + 1] = changes[-1].place
    cost = sum(float(costs[shift][ends[k] : ends[k + 1]].sum()) for k, shift in enumerate(shifts))
    return Placed(Slips.changing((shape[0], shape[1]), shifts[0], changes), cost + 2 * explained.path_freedom())


def likeliest(frames: int, screen: Callable[[Slips], Measurement], suspects: Iterable[Slips]) -> Placed | None:
    """Give the shifts of a run that make its values likeliest, each with the path and the image that they give.

    Args:
        frames: frames of the run.
        screen: function that gives the run whose values came by some shifts.
        suspects: shifts that it may have beside none, frames about the changes not sure. One that proves to change in the last
            frame, after which nothing comes that could tell, is left out.

    Returns:
        The run by these shifts; None where none of them gives path and image.
    """
    raw = screen(Slips.none(frames))
    last_frame = raw.values.size - raw.values.shape[1]
    found: list[Placed] = []
    for slips in (Slips.none(frames), *suspects):
        with suppress(InputError, np.linalg.LinAlgError):
            found.append(placed(raw, slips, at_first_sight(screen(slips))))
    found = [one for one in found if not one.slips.changes or one.slips.changes[-1].place < last_frame]
    if not found:
        return None
    none = min((one for one in found if not one.slips.any), key=lambda one: one.cost, default=None)
    best = min(found, key=lambda one: one.cost)
    with suppress(InputError, np.linalg.LinAlgError):
        for _ in range(_LOOKS if best.slips.changes else 0):
            again = placed(raw, best.slips, at_first_sight(screen(best.slips)))
            if not again.cost < best.cost or again.slips.changes == best.slips.changes:
                break
            best = again
    if best.slips.changes and best.slips.changes[-1].place >= last_frame:
        return none
    return replace(best, gain=np.inf if none is None else none.cost - best.cost)


def _costs(raw: Measurement, explained: Explained, shifts: Integers) -> dict[int, Floats]:
    """Give what each value costs as one of the pattern that it has by each shift: minus twice the logarithm of its likelihood.

    Returns:
        For each shift ``(frames * patterns_per_frame,)`` in the order in which values came; 0 where one is not known.
    """
    expected, costs = explained.values(), dict[int, Floats]()
    light = explained.measurement.light
    usual = float(np.log(np.nanmean(raw.lit_by(light).variance)))  # a light model that takes a leak out enlarges all
    for shift in shifts.tolist():
        moved = by_patterns(raw, shift).lit_by(light)
        variance = _variance(moved, expected)
        cost = np.minimum((moved.values - expected) ** 2 / variance, _MOST) + np.log(variance) - usual
        costs[shift] = np.roll(np.nan_to_num(cost).ravel(), shift)
    return costs


def _variance(measurement: Measurement, expected: Floats) -> Floats:
    """Give the variance of each value if it is as expected: in proportion, where photons are counted."""
    variance = measurement.variance
    known = np.isfinite(variance) & np.isfinite(measurement.values)
    mean = float(variance[known].mean())
    if not measurement.photon_counts:
        return np.full(expected.shape, mean)
    return np.maximum(expected * (mean / float(measurement.values[known].mean())), _LEAST * mean)
