"""Positions of a stream of frames, one frame at a time: the first half of the streaming tracker."""

import numpy as np

from instrument.numerics import compiled, inlined
from instrument.schemes import Scheme, position_of
from protocols import Floats, Integers

_SIGNAL_THETA = (
    1 - 1 / 4.0
)  # share of its weight that a frame keeps in the mean signal by which whole periods are counted


class PlaceStream:
    """Takes values as they come and gives the position along each axis from its signal alone."""

    def __init__(self, scheme: Scheme, total_memory_frames: float) -> None:
        """Prepare for one run.

        Args:
            scheme: scheme of the values.
            total_memory_frames: number of frames over which the total light is averaged.

        Raises:
            InputError: the scheme sees no position.
        """
        reading = position_of(scheme)
        parts = reading.response.shape[2]
        self._light_weights = scheme.light_weights.copy()
        # Weights for whole frames of values are 0 for the patterns that do not measure the axis.
        self._weights = np.zeros((2, parts, len(self._light_weights)))
        for axis in range(2):
            self._weights[axis][:, reading.columns[axis]] = reading.weights[axis]
        self._offset = np.ascontiguousarray(reading.offset)
        self._light_theta = 1 - 1 / total_memory_frames
        self._px_per_radian = 0.0 if reading.period_px is None else reading.period_px / (2 * np.pi)
        self._frames = np.zeros(1, np.int64)
        self._last_good = np.zeros(len(self._light_weights))
        self._light_sum, self._weight_sum = np.zeros(1), np.zeros(1)
        self._mean_signal = np.zeros((2, 2))
        self._mean_angle = np.zeros(2)
        self._periods = np.zeros(2)

    def push(self, values: Floats) -> Floats:
        """Take the values of the next frames, ``(n, patterns_per_frame)``.

        Returns:
            ``(k, 2)`` positions in px, x and y, of all frames from the first good one on; after it, k is n. A frame that is not
            good repeats the good one before it.
        """
        places_px = np.empty((len(values), 2))
        before = _places(
            np.ascontiguousarray(values, np.float64),
            self._light_weights,
            self._weights,
            self._offset,
            self._light_theta,
            self._px_per_radian,
            self._frames,
            self._last_good,
            self._light_sum,
            self._weight_sum,
            self._mean_signal,
            self._mean_angle,
            self._periods,
            places_px,
        )
        return places_px[before:]


@inlined
def _take_if_good(values: Floats, light_weights: Floats, last_good: Floats) -> bool:
    """Copy the values of a frame to ``last_good`` if all are finite and their total light is above 0; tell whether they are."""
    total, finite = 0.0, True
    for k in range(len(last_good)):
        total += light_weights[k] * values[k]
        finite = finite and np.isfinite(values[k])
    good = finite and total > 0
    if good:
        last_good[:] = values
    return good


@inlined
def _signal(offset: float, weights: Floats, values: Floats, weight_sum: float, light_sum: float) -> float:
    """Give one part of an axis's signal: the weighted sum of the values over the mean total light, light_sum / weight_sum."""
    signal = offset
    for k in range(len(values)):
        signal += weights[k] * values[k] * weight_sum / light_sum
    return signal


@compiled(
    "i8(f8[:, ::1], f8[::1], f8[:, :, ::1], f8[:, ::1], f8, f8, i8[::1], f8[::1], f8[::1], f8[::1], f8[:, ::1],"
    " f8[::1], f8[::1], f8[:, ::1])"
)
def _places(  # noqa: PLR0917
    values: Floats,
    light_weights: Floats,
    weights: Floats,
    offset: Floats,
    light_theta: float,
    px_per_radian: float,
    frames: Integers,
    last_good: Floats,
    light_sum: Floats,
    weight_sum: Floats,
    mean_signal: Floats,
    mean_angle: Floats,
    periods: Floats,
    places_px: Floats,
) -> int:
    """Write positions, and return the number of frames before the first good one. Arrays from ``frames`` on are updated.

    The angle of the signal gives the position within a period. Whole periods are counted by the angle of the fading mean signal,
    which is less noisy.

    Args:
        values: ``(n, patterns_per_frame)``.
        light_weights: ``(patterns_per_frame,)`` weights of the total light.
        weights: ``(2, parts, patterns_per_frame)`` weights of each axis's signal; the parts are real and imaginary.
        offset: ``(2, parts)`` constant part of the signal.
        light_theta: share of its weight that a frame keeps in the mean total light.
        px_per_radian: displacement for one radian of the signal's angle; 0 where the signal is the position itself.
        frames: ``(1,)`` number of good frames and repetitions so far.
        last_good: ``(patterns_per_frame,)`` values of the last good frame.
        light_sum: ``(1,)`` fading sum of the total light.
        weight_sum: ``(1,)`` fading sum of 1.
        mean_signal: ``(2, 2)`` fading sum of each axis's signal, real and imaginary part.
        mean_angle: ``(2,)`` angle of that sum in rad.
        periods: ``(2,)`` whole periods that it has turned.
        places_px: ``(n, 2)``; receives the positions.
    """
    before = 0
    for row in range(len(values)):
        good = _take_if_good(values[row], light_weights, last_good)
        if not good and frames[0] == 0:
            before += 1
            continue
        total = 0.0
        for k in range(len(last_good)):
            total += light_weights[k] * last_good[k]
        light_sum[0] = light_theta * light_sum[0] + total
        weight_sum[0] = light_theta * weight_sum[0] + 1
        for axis in range(2):
            real = _signal(offset[axis, 0], weights[axis, 0], last_good, weight_sum[0], light_sum[0])
            if px_per_radian == 0:
                places_px[row, axis] = real
                continue
            imaginary = _signal(offset[axis, 1], weights[axis, 1], last_good, weight_sum[0], light_sum[0])
            mean_signal[axis, 0] = _SIGNAL_THETA * mean_signal[axis, 0] + real
            mean_signal[axis, 1] = _SIGNAL_THETA * mean_signal[axis, 1] + imaginary
            angle = np.arctan2(mean_signal[axis, 1], mean_signal[axis, 0])
            if frames[0] > 0:
                periods[axis] += np.round((mean_angle[axis] - angle) / (2 * np.pi))
            mean_angle[axis] = angle
            cosine, sine = np.cos(angle), np.sin(angle)
            from_mean = np.arctan2(imaginary * cosine - real * sine, real * cosine + imaginary * sine)
            places_px[row, axis] = -(angle + 2 * np.pi * periods[axis] + from_mean) * px_per_radian
        frames[0] += 1
    return before
