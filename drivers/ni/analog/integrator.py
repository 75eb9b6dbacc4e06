"""Samples of light and sync into one value a bin. Arithmetic only: knows no board.

An edge is known to one sample: bin k is the samples from the first one at which the sync is high to the last one before the next
edge. Its value is the mean of those behind the settling. The noise of a sample is estimated from differences of neighbours inside
bins, ``s^2 = mean((x[i+1] - x[i])^2) / 2``, which a level that changes slowly does not disturb; for white noise a value of n
samples has ``s / sqrt(n)``.
"""

from dataclasses import dataclass

import numpy as np

from protocols import Floats, Integers, Mask


@dataclass(frozen=True, eq=False)
class Integrated:
    """Bins that have closed."""

    values_v: Floats
    """``(n,)`` mean of the settled samples of each bin, in volts."""

    edges: Integers
    """``(n + 1,)`` sample index of the edges, since the start; empty where no bin closed."""

    overloaded: Mask
    """``(n,)`` True where a sample of the bin reached the limit."""


class Integrator:
    """Keeps what has not closed yet."""

    def __init__(self, *, high_v: float, low_v: float, settle_samples: int, limit_v: float) -> None:
        """Begin before the first sample.

        Args:
            high_v: an edge is where the sync rises to this.
            low_v: it must have fallen below this since the edge before.
            settle_samples: left out behind each edge.
            limit_v: size of a sample from which on it is overloaded.
        """
        self._high_v, self._low_v, self._settle, self._limit_v = high_v, low_v, settle_samples, limit_v
        self.edges_seen = 0
        self._is_high = True  # what is high from the start is no edge
        self._taken = 0
        self._signal: Floats = np.empty(0)
        self._open: int | None = None
        self._squares, self._differences, self._settled, self._bins = 0.0, 0, 0, 0

    def feed(self, signal_v: Floats, sync_v: Floats) -> Integrated:
        """Take ``(n,)`` samples of both; give the bins that they close."""
        rising = self._rising(sync_v) + self._taken
        self._taken += len(signal_v)
        self.edges_seen += len(rising)
        self._signal = np.concatenate([self._signal, signal_v])
        first = self._taken - len(self._signal)
        edges = rising if self._open is None else np.concatenate([[self._open], rising])
        if len(edges):
            self._open = int(edges[-1])
        keep = self._taken if self._open is None else self._open
        signal, self._signal = self._signal, self._signal[keep - first :]
        if len(edges) < 2:
            return Integrated(np.empty(0), np.empty(0, np.int64), np.empty(0, np.bool_))
        return self._bins_of(signal, edges - first, edges)

    @property
    def sample_noise_v(self) -> float | None:
        """Estimated noise of one sample, in volts; None before there were two neighbours."""
        return float(np.sqrt(self._squares / self._differences / 2)) if self._differences else None

    @property
    def value_noise_v(self) -> float | None:
        """Estimated noise of one value, in volts, where that of the samples is white."""
        sample_v = self.sample_noise_v
        return None if sample_v is None or not self._settled else sample_v / np.sqrt(self._settled / self._bins)

    def _rising(self, sync_v: Floats) -> Integers:
        """Give the indices at which the sync becomes high, with hysteresis across calls."""
        told = (sync_v >= self._high_v) | (sync_v < self._low_v)
        last = np.maximum.accumulate(np.where(told, np.arange(len(sync_v)), -1))
        high = np.where(last >= 0, sync_v[last] >= self._high_v, self._is_high)
        before = np.concatenate([[self._is_high], high[:-1]])
        if len(high):
            self._is_high = bool(high[-1])
        return np.flatnonzero(high & ~before)

    def _bins_of(self, signal: Floats, at: Integers, edges: Integers) -> Integrated:
        opens, closes = at[:-1], at[1:]
        begins = np.minimum(opens + self._settle, closes - 1)  # a bin too short to settle has its last sample
        sums = np.concatenate([[0.0], np.cumsum(signal)])
        n = closes - begins
        values = (sums[closes] - sums[begins]) / n
        over = np.concatenate([[0], np.cumsum(np.abs(signal) >= self._limit_v)])
        squares = np.concatenate([[0.0], np.cumsum(np.diff(signal, append=signal[-1]) ** 2)])
        self._squares += float(np.sum(squares[closes - 1] - squares[begins]))
        self._differences += int(np.sum(n - 1))
        self._settled += int(np.sum(n))
        self._bins += len(n)
        return Integrated(values, edges, over[closes] > over[opens])
