"""Fading-memory filters: recursive sums, so that a stream may be cut into any blocks. Series have time as their last axis.

References:
    Morrison, "Introduction to Sequential Smoothing and Prediction" (1969), chapter 13: fading-memory polynomial filters.
"""

import numpy as np
from scipy.signal import lfilter

from protocols import Floats

_FORGOTTEN = 40  # memories after which the oldest weight, exp(-40), is below the last digit


class FadingMean:
    """Exponentially fading mean, true to its weights from the first frame on."""

    def __init__(self, memory_frames: float, series: int) -> None:
        """Prepare for so many series; a frame's weight falls by ``1 - 1 / memory_frames`` with each newer one."""
        kept = 1 - 1 / memory_frames
        self._below = [1.0, -kept]
        self._state = np.zeros((series, 1))
        self._weights: Floats = np.cumsum(kept ** np.arange(round(_FORGOTTEN * memory_frames), dtype=np.float64))
        self._count = 0

    def push(self, series: Floats) -> Floats:
        """Mean of all frames so far, for each frame of ``(series, n)``."""
        total, self._state = _recursive([1.0], self._below, series, self._state)
        weights = _from(self._weights, self._count, series.shape[1])
        self._count += series.shape[1]
        return total / weights


class FadingParabola:
    """Least squares of a parabola through the past of two series. Frame 0 is found by another parabola, of plain weights."""

    def __init__(self, memory_frames: float, ahead_frames: tuple[float, float]) -> None:
        """Prepare.

        Args:
            memory_frames: a frame's weight falls by ``1 - 1 / memory_frames`` with each newer one.
            ahead_frames: for each series, how long after its measurement the answer is to hold.
        """
        kept = 1 - 1 / memory_frames
        self._states = [np.zeros((2, order)) for order in (1, 2, 3)]
        # Age moments as recursions: sum of kept^i z, of i kept^i z, and of i^2 kept^i z, i frames ago.
        self._recursions = [
            ([1.0], [1.0, -kept]),
            ([0.0, kept], [1.0, -2 * kept, kept**2]),
            ([0.0, kept, kept**2], [1.0, -3 * kept, 3 * kept**2, -(kept**3)]),
        ]
        age = np.arange(round(_FORGOTTEN * memory_frames), dtype=np.float64)
        inverse = _inverses(age, kept**age)
        self._here = _rows(inverse, (0.0, 0.0))
        self._ahead = _rows(inverse, (-ahead_frames[0], -ahead_frames[1]))
        # The end of a plain parabola over 4.4 memories is as sure as that of the fading one.
        start = np.arange(round(4.4 * memory_frames), dtype=np.float64)
        self._first = _rows(_inverses(start, np.ones(len(start))), ahead_frames)
        self._first_sums = np.zeros((3, 2, 1))
        self._first_place = np.zeros((2, 1))
        self._count = 0

    def push(self, place: Floats) -> tuple[Floats, Floats, Floats]:
        """Take the next frames, ``(2, n)``.

        Returns:
            Displacement from frame 0, ``(2, n)``; what the parabola leaves of each datum, ``(2, n)``; and its gain, the share of
            each datum in its own answer, ``(1, n)`` or ``(1, 1)``.
        """
        sums: list[Floats] = []
        for order, (above, below) in enumerate(self._recursions):
            moment, self._states[order] = _recursive(above, below, place, self._states[order])
            sums.append(moment)
        here = _from(self._here, self._count, place.shape[1])
        ahead = _from(self._ahead, self._count, place.shape[1])
        displacement = _combined(ahead, sums) - self._start(place)
        self._count += place.shape[1]
        return displacement, place - _combined(here, sums), here[0, :1]

    def _start(self, place: Floats) -> Floats:
        """Where frame 0 was, as far as known at each frame."""
        size = place.shape[1]
        left = min(max(self._first.shape[2] - self._count, 0), size)
        if left == 0:
            return self._first_place
        index = self._count + np.arange(left, dtype=np.float64)
        new = place[:, :left] * np.stack([np.ones(left), index, index**2])[:, None]
        sums = np.cumsum(np.concatenate([self._first_sums, new], axis=2), axis=2)
        self._first_sums = sums[:, :, -1:]
        found = _combined(_from(self._first, self._count, left), list(sums[:, :, 1:]))
        self._first_place = found[:, -1:]
        return np.concatenate([found, np.broadcast_to(self._first_place, (2, size - left))], axis=1)


def _recursive(above: list[float], below: list[float], series: Floats, state: Floats) -> tuple[Floats, Floats]:
    out, left = lfilter(above, below, series, zi=state)
    return np.asarray(out, np.float64), np.asarray(left, np.float64)


def _from(table: Floats, first: int, count: int) -> Floats:
    """``count`` entries from ``first`` on; after the table's end the last one, which has become constant, holds."""
    size = table.shape[-1]
    if first >= size - 1:
        return table[..., -1:]
    return table[..., np.minimum(first + np.arange(count), size - 1)]


def _combined(rows: Floats, moments: list[Floats]) -> Floats:
    """Three moments times three coefficients; written out, so that the order of additions never changes."""
    value: Floats = rows[0] * moments[0] + rows[1] * moments[1] + rows[2] * moments[2]
    return value


def _inverses(time: Floats, weights: Floats) -> Floats:
    """Inverse normal matrices of parabolas through the first 1, 2, 3, ... times, ``(times, 3, 3)``."""
    moments = np.cumsum(weights * time ** np.arange(5)[:, None], axis=1)
    normal = moments[np.add.outer(np.arange(3), np.arange(3))].transpose(2, 0, 1)
    return np.concatenate([np.linalg.pinv(normal[:2]), np.linalg.inv(normal[2:])]).astype(np.float64)


def _rows(inverse: Floats, times: tuple[float, float]) -> Floats:
    """Coefficients of the moments that give the parabola's value at each series' time, ``(3, 2, times)``."""
    rows = [inverse[:, 0] + time * inverse[:, 1] + time**2 * inverse[:, 2] for time in times]
    return np.ascontiguousarray(np.stack(rows).transpose(2, 0, 1))
