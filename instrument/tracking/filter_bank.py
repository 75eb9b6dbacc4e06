"""A causal filter that follows slow motion calmly and fast motion nimbly: the judging half of the streaming tracker.

Each axis goes through a few fading-memory parabolas (constant acceleration), from nimble to calm. The answer is the mean of
theirs, weighted by each one's unbiased risk of late: mean squared residual + 2 * noise variance * gain. Where frame 0 was is
found by plain parabolas through the first frames.

References:
    Stein, Annals of Statistics 9 (1981) 1135-1151: unbiased risk.
"""

import numpy as np

from instrument.numerics import add, age, compiled, solve
from protocols import Floats, Integers

_MEMORIES_FRAMES = np.array([1.5, 4.0, 14.0, 50.0])
# Frames over which the end of a plain parabola is as sure as that of the fading one.
_START_FRAMES = np.round(4.4 * _MEMORIES_FRAMES)
_JUDGED_FRAMES = 60.0  # over which a filter is judged
_JUDGED_KEPT = 1 - 1 / _JUDGED_FRAMES
_TINY = 1e-12


class FilterBank:
    """Takes positions as they come and gives displacements from frame 0."""

    def __init__(self, ahead_frames: tuple[float, float]) -> None:
        """Prepare; ``ahead_frames`` is, for each axis, how long after its measurement the answer is to hold."""
        members = len(_MEMORIES_FRAMES)
        self._ahead_frames = np.array(ahead_frames)
        self._frames = np.zeros(1, np.int64)
        self._last_px = np.zeros((2, 3))
        self._noise = np.zeros((2, 2))
        self._residual_px2 = np.zeros((members, 2))
        self._start_px = np.zeros((members, 2))
        self._fading_powers, self._plain_powers = np.zeros((members, 5)), np.zeros((members, 5))
        self._fading_moments, self._plain_moments = np.zeros((members, 2, 3)), np.zeros((members, 2, 3))

    def push(self, places_px: Floats) -> Floats:
        """Take the next frames, ``(n, 2)`` x and y, and give their displacements by what was known then, ``(n, 2)``."""
        displacement_px = np.zeros(places_px.shape)
        _filter(
            np.ascontiguousarray(places_px),
            self._ahead_frames,
            self._frames,
            (self._last_px, self._noise),
            (self._residual_px2, self._start_px),
            (self._fading_powers, self._plain_powers),
            (self._fading_moments, self._plain_moments),
            displacement_px,
        )
        return displacement_px


@compiled(
    "void(f8[:, ::1], f8[::1], i8[::1], UniTuple(f8[:, ::1], 2), UniTuple(f8[:, ::1], 2), UniTuple(f8[:, ::1], 2),"
    " UniTuple(f8[:, :, ::1], 2), f8[:, ::1])"
)
def _filter(  # noqa: PLR0917
    places_px: Floats,
    ahead_frames: Floats,
    frames: Integers,
    axis_state: tuple[Floats, Floats],
    member_state: tuple[Floats, Floats],
    powers: tuple[Floats, Floats],
    moments: tuple[Floats, Floats],
    displacement_px: Floats,
) -> None:
    """Write the displacement of each frame by what is known at it.

    Args:
        places_px: ``(n, 2)``.
        ahead_frames: ``(2,)`` as ``FilterBank`` takes them.
        frames: ``(1,)`` frames so far.
        axis_state: last three positions of each axis, newest last, ``(2, 3)``; fading sums over the frames of 1, and of the
            noise variance that each frame shows, both of each axis, ``(2, 2)``.
        member_state: fading sum of each filter's squared residuals, and position of frame 0 by each filter, ``(members, 2)``.
        powers: of the fading parabolas, and of the plain ones through the first frames, ``(members, 5)``.
        moments: likewise, ``(members, 2, 3)``.
        displacement_px: ``(n, 2)`` of zeros.
    """
    last_px, noise = axis_state
    residual_px2, start_px = member_state
    fading_powers, plain_powers = powers
    fading_moments, plain_moments = moments
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
            noise[0, axis] = _JUDGED_KEPT * noise[0, axis] + 1
            noise[1, axis] = _JUDGED_KEPT * noise[1, axis] + third * third / 20
        frames[0] += 1

        for member in range(len(start_px)):
            memory, ends = _MEMORIES_FRAMES[member], _START_FRAMES[member]
            if frames[0] <= ends:
                add(plain_powers[member], plain_moments[member], (frames[0] - 1) / ends, place_px)
                solve(plain_powers[member], plain_moments[member], frames[0], 1 / ends, curve)
                for axis in range(2):
                    later = ahead_frames[axis] / ends
                    start_px[member, axis] = curve[axis, 0] + later * (curve[axis, 1] + later * curve[axis, 2])
            age(fading_powers[member], fading_moments[member], 1 - 1 / memory, 1 / memory)
            add(fading_powers[member], fading_moments[member], 0.0, place_px)
            gain = solve(fading_powers[member], fading_moments[member], frames[0], 1 / memory, curve)
            for axis in range(2):
                later = -ahead_frames[axis] / memory
                there = curve[axis, 0] + later * (curve[axis, 1] + later * curve[axis, 2])
                answer_px[member, axis] = there - start_px[member, axis]
                residual = place_px[axis] - curve[axis, 0]
                residual_px2[member, axis] = _JUDGED_KEPT * residual_px2[member, axis] + residual * residual
                variance = noise[1, axis] + _TINY * noise[0, axis]
                risk[member, axis] = residual_px2[member, axis] / variance + 2 * gain

        for axis in range(2):
            least = risk[:, axis].min()
            whole = 0.0
            for member in range(len(start_px)):
                weight = np.exp(-_JUDGED_FRAMES / 2 * (risk[member, axis] - least))
                whole += weight
                displacement_px[row, axis] += weight * answer_px[member, axis]
            displacement_px[row, axis] /= whole
