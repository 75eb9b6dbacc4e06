"""The shifts of all frames that cost least together: dynamic programming over frames and shifts, exact."""

from typing import Final

import numpy as np

from instrument.measurement.levels import Levels
from instrument.numerics import compiled
from protocols import Floats, Integers

_PASSED_OVER: Final = 2
"""Frames at most between the last one of a shift and the first of the next: what was counted while it changed."""

_EACH_MORE: Final = 10.0
"""Cost of each pattern more by which the shift changes at once."""

_BACK: Final = 0.75
"""Cost of a change back to no shift, over that of another: after a lost edge a gained one is likelier than either alone."""

_START: Final = 0.4
"""Cost of a start with a shift, over that of a change: no level says that nothing changes there."""

_EACH_PASSED: Final = 2.0
"""Cost of a frame that is passed over."""

_SHORT: Final = 4.0
"""Cost of levels from few frames, where those from many do not go on: as many as there are changes within them."""

_UNKNOWN: Final = 5.0
"""Cost of a level that is not known before or after a change, as in the first frames: that a run starts so is likelier."""

_MOST: Final = 60.0
"""Cost at most of one level that does not go on."""


def cheapest_shifts(
    pairs: Floats, jumps: Floats, levels: Levels, change: float, *, margins: bool
) -> tuple[Integers, Floats]:
    """Find the shift of each frame, and how much more the best path of another shift there would cost.

    Args:
        pairs: ``(frames, shifts)`` cost of a frame that has that shift.
        jumps: ``(frames,)`` cost of a frame that follows another one without a change.
        levels: levels before and after each frame.
        change: cost of a change of the shift by one pattern, and of a start with one.
        margins: whether the costs of other paths are wanted, which takes longer.

    Returns:
        ``(frames,)`` shift, from -most to most where there are 2 most + 1 shifts; ``(frames,)`` margin, infinite where it is not
        wanted.
    """
    frames, shifts = pairs.shape
    both = np.full((2, frames, shifts), np.inf)
    came = np.zeros((frames, shifts), np.int64)
    rule = np.array([change, margins], np.float64)
    _least(np.ascontiguousarray(pairs), np.ascontiguousarray(jumps), levels.before, levels.after, rule, both, came)
    total, left = both
    frame, state = frames - 1, int(total[-1].argmin())
    best = float(total[frame, state])
    shift = np.zeros(frames, np.int64)
    margin = np.full(frames, np.inf)
    while frame >= 0:
        shift[frame] = state - shifts // 2
        back = int(came[frame, state])
        if back < 0:
            break
        shift[frame - back // shifts + 1 : frame] = shift[frame]
        frame, state = frame - back // shifts, back % shifts
    if margins:
        around = total + left
        around[np.arange(frames), shift + shifts // 2] = np.inf
        margin = np.maximum(around.min(axis=1) - best, 0.0)
    return shift, margin


@compiled("void(f8[:,::1], f8[::1], f8[:,:,:,::1], f8[:,:,:,::1], f8[::1], f8[:,:,::1], i8[:,::1])")
def _least(  # noqa: PLR0917 - compiled: one array each
    pairs: Floats,
    jumps: Floats,
    before: Floats,
    after: Floats,
    rule: Floats,
    both: Floats,
    came: Integers,
) -> None:
    """Fill ``both``, the least cost up to each frame and shift and that from there to the end, and where paths came from.

    ``came`` is the number of frames back times the number of shifts, plus the shift there; -1 for a start. ``rule`` is the cost
    of a change, and whether margins are wanted: without them the costs to the end are left as they are, and changes that cannot
    be on the cheapest path are not looked at.
    """
    frames, shifts = pairs.shape
    windows, _, per_frame, _ = before.shape
    change, margins = rule[0], rule[1] > 0
    total, left = both[0], both[1]
    middle = shifts // 2
    steps = np.full((frames if margins else 1, _PASSED_OVER + 1, shifts, shifts), np.inf)
    for frame in range(frames):
        for new in range(shifts):
            apart = abs(new - middle)
            if frame == 0:
                total[0, new] = pairs[0, new] + (_START * change + _EACH_MORE * (apart - 1) if apart else 0.0)
                came[0, new] = -1
                continue
            total[frame, new] = total[frame - 1, new] + jumps[frame] + pairs[frame, new]
            came[frame, new] = shifts + new
        for passed in range(min(_PASSED_OVER, frame - 1) + 1):
            last = frame - 1 - passed
            for new in range(shifts):
                for old in range(shifts):
                    apart = abs(new - old)
                    if not apart:
                        continue
                    cost = (_BACK if new == middle else 1.0) * change + _EACH_MORE * (apart - 1)
                    cost += _EACH_PASSED * passed + pairs[frame, new]
                    if not margins and total[last, old] + cost >= total[frame, new]:
                        continue
                    least = np.inf if margins else total[frame, new] - total[last, old] - cost
                    for window in range(windows):
                        off = _SHORT * window
                        for column in range(per_frame):
                            if off >= least:
                                break
                            here = last + (column + old - middle) // per_frame
                            there = frame + (column + new - middle) // per_frame
                            if here < 0 or there < 0 or here >= frames or there >= frames:
                                off += _UNKNOWN
                                continue
                            one = before[window, here, (column + old - middle) % per_frame]
                            two = after[window, there, (column + new - middle) % per_frame]
                            step = two[0] - one[0] - 0.5 * passed * (one[1] + two[1])
                            energy = step * step / (one[2] + two[2])
                            off += min(energy, _MOST) if np.isfinite(energy) else _UNKNOWN
                        least = min(least, off)
                    cost += least
                    if margins:
                        steps[frame, passed, old, new] = cost
                    if total[last, old] + cost < total[frame, new]:
                        total[frame, new] = total[last, old] + cost
                        came[frame, new] = (passed + 1) * shifts + old
    if not margins:
        return
    left[frames - 1] = 0.0
    for frame in range(frames - 2, -1, -1):
        for old in range(shifts):
            left[frame, old] = left[frame + 1, old] + jumps[frame + 1] + pairs[frame + 1, old]
            for passed in range(min(_PASSED_OVER, frames - 2 - frame) + 1):
                for new in range(shifts):
                    cost = steps[frame + 1 + passed, passed, old, new] + left[frame + 1 + passed, new]
                    left[frame, old] = min(left[frame, old], cost)
