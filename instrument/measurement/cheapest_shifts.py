"""The shifts of all frames that cost least together: dynamic programming over frames and shifts, exact."""

from typing import Final

import numpy as np

from instrument.numerics import compiled
from protocols import Floats, Integers

_PASSED_OVER: Final = 2
"""Frames at most that are passed over at once."""

_EACH_MORE: Final = 10.0
"""Cost of each pattern more by which it changes at once."""

_BACK: Final = 0.3
"""Cost of a change back to no shift, over that of another: a lost edge and a gained one cost little more than one of them."""

_BAD: Final = 60.0
"""Cost of frames that are passed over without a change: they fit to no neighbour."""

_MOST: Final = 30.0
"""Cost at most of one value: a wild count says little."""


def cheapest_shifts(
    quiet: Floats, steady: Floats, variance: Floats, loud: Floats, change: float, *, margins: bool
) -> tuple[Integers, Floats]:
    """Find the shift of each frame, and how much more the best path of another shift there would cost.

    Args:
        quiet: ``(frames, shifts, m)`` values that change little from frame to frame, if a frame has that shift; NaN where
            nothing is known.
        steady: likewise, their steady change from the frame before.
        variance: likewise, their variances.
        loud: ``(frames, shifts)`` cost of the values that change much, against the frame before.
        change: cost of a change of the shift by one pattern, and of a start with one.
        margins: whether the costs of other paths are wanted, which takes much longer.

    Returns:
        ``(frames,)`` shift, from -most to most where there are 2 most + 1 shifts; ``(frames,)`` margin, infinite where it is not
        wanted, 0 where the frame is passed over.
    """
    frames, shifts, count = quiet.shape
    both = np.full((2, frames, shifts), np.inf)
    came = np.zeros((frames, shifts), np.int64)
    rule = np.array([change, margins], np.float64)
    quiet, steady, variance, loud = (np.ascontiguousarray(part, np.float64) for part in (quiet, steady, variance, loud))
    _least(quiet, steady, variance, loud, rule, both, came)
    shift = np.zeros(frames, np.int64)
    margin = np.zeros(frames)
    total, left = both
    to_end = np.full_like(total, np.inf)
    for after in range(min(_PASSED_OVER + 1, frames)):
        to_end[frames - 1 - after] = total[frames - 1 - after] + (count + 1.0) * after + (_BAD if after else 0.0)
    frame, state = divmod(int(to_end.argmin()), shifts)
    best = float(to_end[frame, state])
    shift[frame:] = state - shifts // 2
    while True:
        others = np.delete(total[frame] + left[frame], state)
        margin[frame] = float(others.min()) - best if margins else np.inf
        shift[frame] = state - shifts // 2
        back = int(came[frame, state])
        if back < 0:
            shift[:frame] = shift[frame]
            return shift, margin
        before = frame - back // shifts
        shift[before + 1 : frame] = shift[frame]
        frame, state = before, back % shifts


@compiled("void(f8[:,:,::1], f8[:,:,::1], f8[:,:,::1], f8[:,::1], f8[::1], f8[:,:,::1], i8[:,::1])")
def _least(  # noqa: PLR0917 - compiled: one array each
    quiet: Floats,
    steady: Floats,
    variance: Floats,
    loud: Floats,
    rule: Floats,
    both: Floats,
    came: Integers,
) -> None:
    """Fill ``both``, the least cost up to each frame and shift and that from there to the end, and where paths came from.

    ``came`` is the number of frames back times the number of shifts, plus the shift there; -1 for a start. ``rule`` is the cost
    of a change, and whether margins are wanted: without them the costs to the end are left as they are, and steps that cannot be
    on the cheapest path are not looked at.
    """
    frames, shifts, count = quiet.shape
    change, margins = rule[0], rule[1] > 0
    total, left = both[0], both[1]
    middle = shifts // 2
    each = count + 1.0  # what a frame costs on average
    steps = np.full((frames if margins else 1, _PASSED_OVER + 1, shifts, shifts), np.inf)
    for frame in range(frames):
        for new in range(shifts):
            if frame <= _PASSED_OVER:
                apart = abs(new - middle)
                total[frame, new] = each * frame + (_BAD if frame else 0.0)
                if apart:
                    total[frame, new] += change + _EACH_MORE * (apart - 1)
                came[frame, new] = -1
            for back in range(1, min(_PASSED_OVER + 1, frame) + 1):
                before = frame - back
                for old in range(shifts):
                    apart = abs(new - old)
                    if back == 1 and apart:
                        continue
                    cost = count * (back - 1.0)
                    if apart:
                        cost += (_BACK if new == middle else 1.0) * change + _EACH_MORE * (apart - 1)
                    elif back > 1:
                        cost += _BAD
                    for passed in range(before + 1, frame + 1):  # what changes much is no reason to pass over a frame
                        cost += min(loud[passed, new], _MOST)
                    if not margins and total[before, old] + cost >= total[frame, new]:
                        continue
                    for k in range(count):
                        step = quiet[frame, new, k] - quiet[before, old, k]
                        if back == 1:
                            step -= steady[frame, new, k]
                        else:
                            step -= back * (steady[frame, new, k] + steady[before, old, k]) / 2
                        energy = step * step / (variance[frame, new, k] + variance[before, old, k])
                        cost += min(energy, _MOST) if np.isfinite(energy) else 1.0
                    if margins:
                        steps[frame, back - 1, old, new] = cost
                    if total[before, old] + cost < total[frame, new]:
                        total[frame, new] = total[before, old] + cost
                        came[frame, new] = back * shifts + old
    if not margins:
        return
    for frame in range(frames - 1, -1, -1):
        after = frames - 1 - frame
        for old in range(shifts):
            if after <= _PASSED_OVER:
                left[frame, old] = each * after + (_BAD if after else 0.0)
            for ahead in range(1, min(_PASSED_OVER + 1, after) + 1):
                for new in range(shifts):
                    left[frame, old] = min(
                        left[frame, old], steps[frame + ahead, ahead - 1, old, new] + left[frame + ahead, new]
                    )
