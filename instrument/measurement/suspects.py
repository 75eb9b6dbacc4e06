"""Where one change of the shift is likeliest by the counts, whether or not they tell that there is any."""

from typing import Final

import numpy as np

from instrument.measurement.slip_evidence import SlipEvidence
from instrument.measurement.slips import Change
from protocols import Floats, Integers

_EACH: Final = 6
"""Places that are given for each shift by one pattern, the likeliest fault."""

_OTHERS: Final = 2
"""Places that are given for each shift by more."""

_APART: Final = 40
"""Frames at least between two places of the same shift."""

_REACH: Final = 12
"""Frames to both sides of a place in which the change may be, if it is there."""

_WINDOWS: Final = 2
"""Lengths of lines by which it is judged whether levels go on: so many of the longest ones."""

_FEWER: Final = 4.0
"""What each shorter length costs: it is believed only where levels by longer lines do not go on."""

_UNKNOWN: Final = 5.0
"""Cost of a level that is not known."""

_MOST: Final = 60.0
"""Cost at most of one level that does not go on."""


def suspects(evidence: SlipEvidence) -> tuple[Change, ...]:
    """Give the places where a change from no shift to each other one costs least.

    The likeliest place of each shift comes first, then the second one of each. Costs of two shifts are hardly to be compared.
    A change costs what pairs cost by no shift before it and by the shift after it, and by how much levels do not go on.
    """
    frames, per_frame = evidence.light.shape
    most = evidence.most if evidence.has_levels else 0
    found: list[tuple[int, float, Change]] = []
    before = np.cumsum(evidence.pairs[:, evidence.most])
    for shift in (shift for shift in range(-most, most + 1) if shift):
        after = np.cumsum(evidence.pairs[::-1, evidence.most + shift])[::-1]
        cost = np.full(frames, np.inf)
        cost[2:] = before[:-2] + after[2:] + _steps(evidence, shift)[2:]
        for rank in range(_EACH if abs(shift) == 1 else _OTHERS):
            frame = int(cost.argmin())
            if not np.isfinite(cost[frame]):
                break
            first, last = max(frame - _REACH, 1), min(frame + _REACH, frames - 1)
            change = Change(per_frame * frame, per_frame * first, per_frame * last, shift)
            found.append((rank, float(cost[frame]), change))
            cost[max(frame - _APART, 0) : frame + _APART] = np.inf
    return tuple(change for *_, change in sorted(found, key=lambda one: one[:2]))


def _steps(evidence: SlipEvidence, shift: int) -> Floats:
    """``(frames,)``: by how much levels do not go on from two frames before each one, by no shift, to it, by a shift."""
    frames, per_frame = evidence.light.shape
    levels = evidence.levels
    frame: Integers = np.arange(frames, dtype=np.int64)
    least = np.full(frames, np.inf)
    for window in range(_WINDOWS):
        total = np.full(frames, _FEWER * window)
        for column in range(per_frame):
            there: Integers = frame + (column + shift) // per_frame
            one = levels.before[window, frame - 2, column]
            two = levels.after[window, there.clip(0, frames - 1), (column + shift) % per_frame]
            step = two[:, 0] - one[:, 0] - 0.5 * (one[:, 1] + two[:, 1])
            energy = np.minimum(step**2 / (one[:, 2] + two[:, 2]), _MOST)
            total += np.where(np.isfinite(energy) & (there < frames), energy, _UNKNOWN)
        least = np.minimum(least, total)
    return least
