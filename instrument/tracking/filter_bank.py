"""A causal filter that adapts its memory to the motion: the second half of the streaming tracker.

Each axis goes through several fading-memory parabolas (constant acceleration) with memories from short to long. The answer is the
mean of their predictions, weighted by each filter's unbiased risk over the last frames: mean squared residual
+ 2 * noise variance * leverage of the newest datum. The position of frame 0 is found by parabolas with equal weights through the
first frames.

References:
    C. M. Stein, Annals of Statistics 9 (1981) 1135-1151: unbiased risk.
"""

from typing import Final

import numpy as np

from instrument.numerics import add, age, compiled, inlined, solve
from protocols import Floats, Integers

_MEMORIES_FRAMES: Final = np.array([1.5, 4.0, 14.0, 50.0])
"""Memory of each filter."""

_START_FRAMES: Final = np.round(4.4 * _MEMORIES_FRAMES)
"""Frames at whose end a parabola with equal weights is as certain as the fading one of the same filter."""

_RISK_FRAMES: Final = 60.0
"""Memory of the filters' risks and of the noise."""

_RISK_THETA: Final = 1 - 1 / _RISK_FRAMES
"""Share of its weight in risk and noise that a frame keeps from one frame to the next."""

_LEAST_VARIANCE_PX2: Final = 1e-12

_TOLD_FROM_FRAMES: Final = 12
"""From so many frames on there is a noise to tell an uncertainty by."""


class FilterBank:
    """Takes positions as they come and gives displacements from frame 0."""

    def __init__(self, delay_frames: tuple[float, float]) -> None:
        """Prepare for one run.

        Args:
            delay_frames: time from the measurement of a position to the time that its displacement is given for, x and y.
        """
        filters = len(_MEMORIES_FRAMES)
        self._delay_frames = np.array(delay_frames)
        self._frames = np.zeros(1, np.int64)
        self._last_px = np.zeros((2, 3))
        self._weight_sum, self._noise_sum_px2 = np.zeros(2), np.zeros(2)
        self._residual_sum_px2 = np.zeros((filters, 2))
        self._start_px = np.zeros((filters, 2))
        self._start_leverage = np.zeros(filters)
        self.sigma_px: Floats = np.zeros((0, 2))
        """``(n, 2)`` standard uncertainty of the displacements that were given last; NaN in the first frames."""
        self._fading_powers, self._fading_moments = np.zeros((filters, 5)), np.zeros((filters, 2, 3))
        self._equal_powers, self._equal_moments = np.zeros((filters, 5)), np.zeros((filters, 2, 3))

    def push(self, places_px: Floats) -> Floats:
        """Take the positions of the next frames and give their displacements, each from what is known at its frame.

        Args:
            places_px: ``(n, 2)`` x and y.

        Returns:
            ``(n, 2)`` displacements, x and y in px.
        """
        displacement_px, self.sigma_px = np.zeros(places_px.shape), np.zeros(places_px.shape)
        _filter(
            np.ascontiguousarray(places_px),
            self._delay_frames,
            self._frames,
            self._last_px,
            self._weight_sum,
            self._noise_sum_px2,
            self._residual_sum_px2,
            self._start_px,
            self._start_leverage,
            self._fading_powers,
            self._fading_moments,
            self._equal_powers,
            self._equal_moments,
            displacement_px,
            self.sigma_px,
        )
        return displacement_px


@inlined
def _third_difference(last_px: Floats, place_px: float) -> float:
    """Give the third difference of the last three positions and a new one, which then replaces the oldest of them."""
    difference: float = place_px - 3 * last_px[2] + 3 * last_px[1] - last_px[0]
    last_px[0], last_px[1], last_px[2] = last_px[1], last_px[2], place_px
    return difference


@inlined
def _at(curve: Floats, time: float) -> float:
    """Give the value of the parabola a + b u + c u^2 at the time u."""
    value: float = curve[0] + time * (curve[1] + time * curve[2])
    return value


@compiled(
    "void(f8[:, ::1], f8[::1], i8[::1], f8[:, ::1], f8[::1], f8[::1], f8[:, ::1], f8[:, ::1], f8[::1],"
    " f8[:, ::1], f8[:, :, ::1], f8[:, ::1], f8[:, :, ::1], f8[:, ::1], f8[:, ::1])"
)
def _filter(  # noqa: PLR0917
    places_px: Floats,
    delay_frames: Floats,
    frames: Integers,
    last_px: Floats,
    weight_sum: Floats,
    noise_sum_px2: Floats,
    residual_sum_px2: Floats,
    start_px: Floats,
    start_leverage: Floats,
    fading_powers: Floats,
    fading_moments: Floats,
    equal_powers: Floats,
    equal_moments: Floats,
    displacement_px: Floats,
    sigma_px: Floats,
) -> None:
    """Write displacement and uncertainty of each frame from what is known at it. All arrays but the first two are updated.

    Args:
        places_px: ``(n, 2)`` positions.
        delay_frames: ``(2,)`` as ``FilterBank`` takes it.
        frames: ``(1,)`` number of frames so far.
        last_px: ``(2, 3)`` last three positions of each axis, the newest last.
        weight_sum: ``(2,)`` fading sum of 1 over the frames.
        noise_sum_px2: ``(2,)`` fading sum of the noise variance that each frame shows.
        residual_sum_px2: ``(filters, 2)`` fading sum of each filter's squared residuals.
        start_px: ``(filters, 2)`` position of frame 0 by each filter.
        start_leverage: ``(filters,)`` its variance, in units of the noise's.
        fading_powers: ``(filters, 5)`` of the fading parabolas, as in ``numerics.fading``.
        fading_moments: ``(filters, 2, 3)`` likewise.
        equal_powers: ``(filters, 5)`` of the parabolas with equal weights through the first frames.
        equal_moments: ``(filters, 2, 3)`` likewise.
        displacement_px: ``(n, 2)`` of zeros.
        sigma_px: ``(n, 2)`` of zeros.
    """
    filters = len(start_px)
    curve, answer_px, risk = np.empty((2, 3)), np.empty((filters, 2)), np.empty((filters, 2))
    leverages = np.empty(filters)
    for row in range(len(places_px)):
        place_px = places_px[row]
        for axis in range(2):
            if frames[0] == 0:
                last_px[axis] = place_px[axis]
            # Motion hardly shows in a third difference; noise of variance v gives it the variance (1 + 9 + 9 + 1) v.
            third = _third_difference(last_px[axis], place_px[axis])
            weight_sum[axis] = _RISK_THETA * weight_sum[axis] + 1
            noise_sum_px2[axis] = _RISK_THETA * noise_sum_px2[axis] + third * third / 20
        frames[0] += 1

        for k in range(filters):
            memory, start = _MEMORIES_FRAMES[k], _START_FRAMES[k]
            if frames[0] <= start:
                add(equal_powers[k], equal_moments[k], (frames[0] - 1) / start, place_px)
                # The first datum of equal weights is as certain as the last one.
                start_leverage[k] = solve(equal_powers[k], equal_moments[k], frames[0], 1 / start, curve)
                for axis in range(2):
                    start_px[k, axis] = _at(curve[axis], delay_frames[axis] / start)
            age(fading_powers[k], fading_moments[k], 1 - 1 / memory, 1 / memory)
            add(fading_powers[k], fading_moments[k], 0.0, place_px)
            leverage = solve(fading_powers[k], fading_moments[k], frames[0], 1 / memory, curve)
            leverages[k] = leverage + start_leverage[k]
            for axis in range(2):
                answer_px[k, axis] = _at(curve[axis], -delay_frames[axis] / memory) - start_px[k, axis]
                residual = place_px[axis] - curve[axis, 0]
                residual_sum_px2[k, axis] = _RISK_THETA * residual_sum_px2[k, axis] + residual * residual
                variance = noise_sum_px2[axis] + _LEAST_VARIANCE_PX2 * weight_sum[axis]
                risk[k, axis] = residual_sum_px2[k, axis] / variance + 2 * leverage

        for axis in range(2):
            least = risk[:, axis].min()
            total, leverage, square_px2 = 0.0, 0.0, 0.0
            for k in range(filters):
                weight = np.exp(-_RISK_FRAMES / 2 * (risk[k, axis] - least))
                total += weight
                displacement_px[row, axis] += weight * answer_px[k, axis]
                square_px2 += weight * answer_px[k, axis] ** 2
                leverage += weight * leverages[k]
            displacement_px[row, axis] /= total
            # The first three frames of a run have no third difference, and show no noise.
            noisy = weight_sum[axis] - (1 - _RISK_THETA ** min(3, frames[0])) / (1 - _RISK_THETA) * _RISK_THETA ** max(
                0, frames[0] - 3
            )
            if frames[0] < _TOLD_FROM_FRAMES:
                sigma_px[row, axis] = np.nan
            else:
                spread_px2 = max(0.0, square_px2 / total - displacement_px[row, axis] ** 2)
                sigma_px[row, axis] = np.sqrt(noise_sum_px2[axis] / noisy * leverage / total + spread_px2)
