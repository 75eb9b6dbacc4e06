"""Between which two values the shift of a run changes, given between which frames it does about."""

from typing import Final

import numpy as np

from instrument.measurement.levels import Levels
from protocols import Floats, Integers

_REACH: Final = 4
"""Frames to both sides among which the place is looked for."""

_MOST: Final = 30.0
"""Cost at most of one value: that in which two bins were joined says nothing."""

_AS_LIKELY: Final = 7.0
"""Cost by which a place is worse that is as good as ruled out: odds of 1 in 30."""


def change_place(
    light: Floats, sigma2: Floats, levels: Levels, frame: int, shifts: tuple[int, int]
) -> tuple[int, int, int]:
    """Find the most likely place of a change of the shift.

    Each value is one of its pattern's level: of the pattern that it has by the shift before if it comes before the change,
    and of that by the shift after if it comes after. Levels are those of a few frames away, where the shift is known.

    Args:
        light: ``(frames, patterns_per_frame)`` in play order; NaN where no value is known.
        sigma2: ``(frames, patterns_per_frame)`` variance of each value by its pattern, once values are in step.
        levels: levels before and after each frame.
        frame: where the change is about.
        shifts: patterns by which values come late before it, and after it.

    Returns:
        The first value, of all in play order, that comes after the change; and the first and the last place that may be it.
    """
    frames, per_frame = light.shape
    low, high = max(0, frame - _REACH), min(frames, frame + _REACH + 1)
    place: Integers = np.arange(low * per_frame, high * per_frame, dtype=np.int64)
    column: Integers = np.arange(per_frame, dtype=np.int64)
    one = levels.before[0, max(low - 1, 0), (column + shifts[0]) % per_frame]
    two = levels.after[0, min(high, frames - 1), (column + shifts[1]) % per_frame]
    away = place / per_frame - (low - 0.5)
    apart = high - low + 0.5
    cost = np.empty((2, len(place)))
    for k, shift in enumerate(shifts):
        of = (place - shift) % per_frame
        part = np.clip(away / apart, 0.0, 1.0)
        known_one, known_two = np.isfinite(one[of, 0]), np.isfinite(two[of, 0])
        part = np.where(known_one & known_two, part, np.where(known_one, 0.0, 1.0))
        level = (1 - part) * np.nan_to_num(one[of, 0]) + part * np.nan_to_num(two[of, 0])
        noise = sigma2[np.clip((place - shift) // per_frame, 0, frames - 1), of]
        energy = (light.ravel()[place] - level) ** 2 / noise
        cost[k] = np.minimum(np.nan_to_num(energy, nan=1.0), _MOST) + np.log(noise)
    start = low * per_frame
    best, first, last = cheapest_place(cost[0], cost[1], _AS_LIKELY)
    return start + best, start + first, start + last


def cheapest_place(before: Floats, after: Floats, as_likely: float) -> tuple[int, int, int]:
    """Give the place of a change that costs least.

    Args:
        before: ``(n,)`` cost of each value, in the order in which values came, were the change after it: minus twice the
            logarithm of its likelihood.
        after: likewise, were it before it.
        as_likely: cost by which a place is worse that is as good as ruled out.

    Returns:
        The first value after the change, 0 to n; and the first and the last one that may be it: any, where no cost is a number.
    """
    total: Floats = np.concatenate([np.zeros(1), np.cumsum(before)])
    total[:-1] += np.cumsum(after[::-1])[::-1]
    total[np.isnan(total)] = np.inf
    best = int(total.argmin())
    likely = np.flatnonzero(total <= total[best] + as_likely)
    return best, int(likely[0]), int(likely[-1])
