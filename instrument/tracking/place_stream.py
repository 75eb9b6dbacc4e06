"""Positions of a stream of frames, one frame at a time: the measuring half of the streaming tracker."""

import numpy as np

from instrument.numerics import compiled
from instrument.schemes import Scheme, position_of
from protocols import Floats, Integers

_CLEAR_KEPT = 1 - 1 / 4.0  # a frame's share in the mean signal after another, by which whole periods are counted


class PlaceStream:
    """Takes values as they come and gives each axis's position by its signal alone."""

    def __init__(self, scheme: Scheme, total_memory_frames: float) -> None:
        """Prepare.

        Args:
            scheme: of the values.
            total_memory_frames: over which the total light is averaged.

        Raises:
            InputError: the scheme sees no position.
        """
        reading = position_of(scheme)
        parts = reading.response.shape[2]
        self._light_weights = scheme.light_weights.copy()
        # Weights for whole frames of values, with 0 for the patterns that do not measure the axis.
        self._weights = np.zeros((2, parts, len(self._light_weights)))
        for axis in range(2):
            self._weights[axis][:, reading.columns[axis]] = reading.weights[axis]
        self._offset = np.ascontiguousarray(reading.offset)
        self._light_kept = 1 - 1 / total_memory_frames
        self._px_per_radian = 0.0 if reading.period_px is None else reading.period_px / (2 * np.pi)
        self._frames = np.zeros(1, np.int64)
        self._last_good = np.zeros(len(self._light_weights))
        self._light = np.zeros(2)
        self._mean_signal = np.zeros((2, 2))
        self._angle = np.zeros(2)
        self._periods = np.zeros(2)

    def push(self, values: Floats) -> Floats:
        """Take the next frames, ``(n, patterns_per_frame)``.

        Returns:
            ``(k, 2)``: position in px along x and y, from the first good frame on: k is n from then on. A bad frame repeats the
            good one before it.
        """
        places_px = np.empty((len(values), 2))
        before = _places(
            np.ascontiguousarray(values, np.float64),
            (self._light_weights, self._weights, self._offset),
            (self._light_kept, self._px_per_radian),
            (self._last_good, self._light),
            (self._mean_signal, self._angle, self._periods),
            self._frames,
            places_px,
        )
        return places_px[before:]


@compiled(
    "i8(f8[:, ::1], Tuple((f8[::1], f8[:, :, ::1], f8[:, ::1])), UniTuple(f8, 2), UniTuple(f8[::1], 2),"
    " Tuple((f8[:, ::1], f8[::1], f8[::1])), i8[::1], f8[:, ::1])"
)
def _places(  # noqa: PLR0917
    values: Floats,
    reading: tuple[Floats, Floats, Floats],
    constants: tuple[float, float],
    frame_state: tuple[Floats, Floats],
    axis_state: tuple[Floats, Floats, Floats],
    frames: Integers,
    places_px: Floats,
) -> int:
    """Write positions, and give the number of frames before the first good one.

    Args:
        values: ``(n, patterns_per_frame)``.
        reading: weights of the total light, ``(patterns_per_frame,)``; weights of each axis's signal,
            ``(2, parts, patterns_per_frame)``; its offset, ``(2, parts)``.
        constants: share of its weight that the light of a frame keeps; px of displacement a radian, 0 where there is no period.
        frame_state: values of the last good frame; fading sum of the total light, and of the weights in that sum.
        axis_state: fading sum of each axis's signal, ``(2, 2)``; angle of that sum; whole periods that it has turned.
        frames: ``(1,)`` good frames, and repetitions of one, so far.
        places_px: ``(n, 2)`` receives the positions.
    """
    light_weights, weights, offset = reading
    light_kept, px_per_radian = constants
    last_good, light = frame_state
    mean_signal, mean_angle, periods = axis_state
    before = 0
    for row in range(len(values)):
        total, finite = 0.0, True
        for k in range(len(last_good)):
            total += light_weights[k] * values[row, k]
            finite = finite and np.isfinite(values[row, k])
        if finite and total > 0:
            last_good[:] = values[row]
        elif frames[0] == 0:
            before += 1
            continue
        total = 0.0
        for k in range(len(last_good)):
            total += light_weights[k] * last_good[k]
        light[0], light[1] = light_kept * light[0] + total, light_kept * light[1] + 1
        for axis in range(2):
            real, imaginary = offset[axis, 0], 0.0
            for k in range(len(last_good)):
                real += weights[axis, 0, k] * last_good[k] * light[1] / light[0]
            if px_per_radian == 0:
                places_px[row, axis] = real
                continue
            imaginary = offset[axis, 1]
            for k in range(len(last_good)):
                imaginary += weights[axis, 1, k] * last_good[k] * light[1] / light[0]
            mean_signal[axis, 0] = _CLEAR_KEPT * mean_signal[axis, 0] + real
            mean_signal[axis, 1] = _CLEAR_KEPT * mean_signal[axis, 1] + imaginary
            angle = np.arctan2(mean_signal[axis, 1], mean_signal[axis, 0])
            if frames[0] > 0:
                periods[axis] += np.round((mean_angle[axis] - angle) / (2 * np.pi))
            mean_angle[axis] = angle
            cosine, sine = np.cos(angle), np.sin(angle)
            aside = np.arctan2(imaginary * cosine - real * sine, real * cosine + imaginary * sine)
            places_px[row, axis] = -(angle + 2 * np.pi * periods[axis] + aside) * px_per_radian
        frames[0] += 1
    return before
