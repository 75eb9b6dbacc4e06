"""A causal filter that follows slow motion calmly and fast motion nimbly: the judging half of the streaming tracker.

Each axis goes through a few fading-memory parabolas (constant acceleration), from nimble to calm. The answer is the mean of
theirs, weighted by each one's unbiased risk of late: mean squared residual + 2 * noise variance * gain. Where frame 0 was is
found by plain parabolas through the first frames.

References:
    Stein, Annals of Statistics 9 (1981) 1135-1151: unbiased risk.
"""

import numpy as np

from instrument.compiled import compiled
from instrument.tracking.fading import add, grow_older, solve
from protocols import Floats, Integers

_MEMORIES_FRAMES = np.array([1.5, 4.0, 14.0, 50.0])
# Over which the end of a plain parabola is as sure as that of the fading one.
_START_FRAMES = np.round(4.4 * _MEMORIES_FRAMES)
_TRUST_FRAMES = 60.0  # over which a filter is judged
_TRUST_KEPT = 1 - 1 / _TRUST_FRAMES
_TINY = 1e-12


class FilterBank:
    """Takes places as they come and gives displacements from frame 0."""

    def __init__(self, ahead_frames: tuple[float, float]) -> None:
        """Prepare; ``ahead_frames`` is, for each axis, how long after its measurement the answer is to hold."""
        members = len(_MEMORIES_FRAMES)
        self._ahead_frames = np.array(ahead_frames)
        self._frames = np.zeros(1, np.int64)
        self._last_px = np.zeros((2, 3))
        self._trust = np.zeros((2 + members, 2))
        self._powers = np.zeros((2, members, 5))
        self._moments = np.zeros((2, members, 2, 3))
        self._start_px = np.zeros((members, 2))

    def push(self, places_px: Floats) -> Floats:
        """Take the next frames, ``(n, 2)`` x and y, and give their displacements by what was known then, ``(n, 2)``."""
        displacement_px = np.zeros(places_px.shape)
        _filter(
            np.ascontiguousarray(places_px),
            self._ahead_frames,
            self._frames,
            (self._last_px, self._trust, self._start_px),
            self._powers,
            self._moments,
            displacement_px,
        )
        return displacement_px


@compiled("void(f8[:, ::1], f8[::1], i8[::1], UniTuple(f8[:, ::1], 3), f8[:, :, ::1], f8[:, :, :, ::1], f8[:, ::1])")
def _filter(  # noqa: PLR0917
    places_px: Floats,
    ahead_frames: Floats,
    frames: Integers,
    kept: tuple[Floats, Floats, Floats],
    powers: Floats,
    moments: Floats,
    displacement_px: Floats,
) -> None:
    """Write displacements.

    ``kept``: the last three places of each axis, newest last; fading sums of the weights, of the noise variance, and of each
    filter's squared residuals; where frame 0 was by each filter. ``powers`` and ``moments``: of the fading parabolas, then of
    those at the start.
    """
    last_px, trust, start_px = kept
    curve, answer_px, risk = np.empty((2, 3)), np.empty(start_px.shape), np.empty(start_px.shape)
    for row in range(len(places_px)):
        place_px = places_px[row]
        # Noise: mean squared third difference, in which motion hardly shows, over 1 + 9 + 9 + 1.
        for axis in range(2):
            last = last_px[axis]
            if frames[0] == 0:
                last[:] = place_px[axis]
            third = place_px[axis] - 3 * last[2] + 3 * last[1] - last[0]
            last[0], last[1], last[2] = last[1], last[2], place_px[axis]
            trust[0, axis] = _TRUST_KEPT * trust[0, axis] + 1
            trust[1, axis] = _TRUST_KEPT * trust[1, axis] + third * third / 20
        frames[0] += 1

        for member in range(len(start_px)):
            memory, ends = _MEMORIES_FRAMES[member], _START_FRAMES[member]
            if frames[0] <= ends:
                add(powers[1, member], moments[1, member], (frames[0] - 1) / ends, place_px)
                solve(powers[1, member], moments[1, member], frames[0], 1 / ends, curve)
                for axis in range(2):
                    later = ahead_frames[axis] / ends
                    start_px[member, axis] = curve[axis, 0] + later * (curve[axis, 1] + later * curve[axis, 2])
            grow_older(powers[0, member], moments[0, member], 1 - 1 / memory, 1 / memory)
            add(powers[0, member], moments[0, member], 0.0, place_px)
            gain = solve(powers[0, member], moments[0, member], frames[0], 1 / memory, curve)
            for axis in range(2):
                later = -ahead_frames[axis] / memory
                there = curve[axis, 0] + later * (curve[axis, 1] + later * curve[axis, 2])
                answer_px[member, axis] = there - start_px[member, axis]
                residual = place_px[axis] - curve[axis, 0]
                trust[2 + member, axis] = _TRUST_KEPT * trust[2 + member, axis] + residual * residual
                noise = trust[1, axis] + _TINY * trust[0, axis]
                risk[member, axis] = trust[2 + member, axis] / noise + 2 * gain

        for axis in range(2):
            least = risk[:, axis].min()
            whole = 0.0
            for member in range(len(start_px)):
                weight = np.exp(-_TRUST_FRAMES / 2 * (risk[member, axis] - least))
                whole += weight
                displacement_px[row, axis] += weight * answer_px[member, axis]
            displacement_px[row, axis] /= whole
