"""How every counter of the head gives bins to the caller: in order, each once, and an error only when nothing good is left.

Counts and the durations of bins arrive from the board apart from each other and in pieces of any size. ``Handover`` keeps
them until both halves of a bin are there; ``collect`` waits on the bench's clock until there are enough.
"""

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from protocols import Clock, CountBlock, CounterRun, Floats, Integers, KinopixError


class Bins(Protocol):
    """Closed bins that the caller has still to get, and the fault that waits behind them."""

    fault: KinopixError | None

    @property
    def left(self) -> int:
        """Number of bins of the run that the caller has not got yet."""
        ...

    @property
    def ready(self) -> int:
        """Number of bins that ``take`` would give now."""
        ...

    def take(self) -> CountBlock:
        """Give all that is ready."""
        ...


class Handover:
    """Closed bins that the caller has still to get, and the fault that waits behind them."""

    def __init__(self, n_bins: int, tick_s: float | None = None) -> None:
        """Start empty.

        Args:
            n_bins: bins of the run; what comes after them is never handed over.
            tick_s: unit of the bin durations; None where the board does not time its edges.
        """
        self.fault: KinopixError | None = None
        self.handed_over = 0
        self._n_bins = n_bins
        self._tick_s = tick_s
        self._counts: NDArray[np.uint32] = np.empty(0, np.uint32)
        self._ticks: Integers = np.empty(0, np.int64)
        self._elapsed_ticks = 0

    @property
    def left(self) -> int:
        """Number of bins of the run that the caller has not got yet."""
        return self._n_bins - self.handed_over

    @property
    def ready(self) -> int:
        """Number of bins that ``take`` would give now."""
        return min(self.left, self._timed or (len(self._counts) if self._untimed_may_go else 0))

    @property
    def notes(self) -> list[str]:
        """New list for a report, with the fault where one broke the run off."""
        broken_off = self.fault is not None and self.left
        return [f"the run broke off: {self.fault}"] if broken_off else []

    def add(self, counts: NDArray[np.uint32], ticks: Integers | None = None) -> None:
        """Put in ``(n,)`` counts and ``(m,)`` durations in ticks, in hardware order; n and m may differ."""
        self._counts = np.concatenate([self._counts, counts])
        if ticks is not None:
            self._ticks = np.concatenate([self._ticks, ticks])

    def fail(self, fault: KinopixError) -> None:
        """Remember the first fault; ``collect`` raises it when the good bins are gone."""
        self.fault = self.fault or fault

    def take(self) -> CountBlock:
        """Give all that is ready. Bins whose duration was lost with a fault come last, without edge times."""
        n = self.ready
        first, self.handed_over = self.handed_over, self.handed_over + n
        counts, self._counts = self._counts[:n], self._counts[n:]
        if self._tick_s is None or (n and not len(self._ticks)):
            return CountBlock(first_bin=first, counts=counts)
        edges_s = self._pass_edges_s(n)
        return CountBlock(
            first_bin=first,
            counts=counts,
            opening_edge_s=edges_s[:-1],
            closing_edge_s=float(edges_s[-1]) if n else None,
        )

    @property
    def _timed(self) -> int:
        return 0 if self._tick_s is None else min(len(self._counts), len(self._ticks))

    @property
    def _untimed_may_go(self) -> bool:
        return self._tick_s is None or self.fault is not None

    def _pass_edges_s(self, n: int) -> Floats:
        ticks, self._ticks = self._ticks[:n], self._ticks[n:]
        edges = self._elapsed_ticks + np.concatenate([np.zeros(1, np.int64), np.cumsum(ticks)])
        self._elapsed_ticks = int(edges[-1])
        return edges * np.float64(self._tick_s or 0.0)


def bins_per_block(run: CounterRun) -> int:
    """Give the number of bins that close in one latency, at least one."""
    return max(1, round(run.latency_s / run.period_s))


def collect(
    handover: Bins, poll: Callable[[int], None], *, run: CounterRun, clock: Clock, timeout_s: float
) -> CountBlock:
    """Poll until about ``run.latency_s`` worth of bins is ready, the run is complete, or ``timeout_s`` has passed.

    Half a block is enough, rather than a second wait. Between two polls lies one latency, so that a board is asked for data at
    most 1 / latency times a second.

    Args:
        handover: where ``poll`` puts what it reads.
        poll: reads what the device has; it may leave fewer than the given number of bins in the device.
        run: for the block size and the pause.
        clock: every pause is taken on it.
        timeout_s: 0 takes what is there.

    Raises:
        KinopixError: the fault that ``poll`` left in ``handover``, once all good bins are handed over.
    """
    deadline_s = clock.now_s() + timeout_s
    enough = (bins_per_block(run) + 1) // 2
    least = enough if timeout_s > 0 else 1
    while handover.left and handover.fault is None:
        poll(min(least, handover.left))
        if handover.ready:
            deadline_s = min(deadline_s, clock.now_s() + run.latency_s)  # what is in hand is not held back
        rest_s = deadline_s - clock.now_s()
        if handover.ready >= min(enough, handover.left) or handover.fault is not None or rest_s <= 0:
            break
        clock.sleep_s(min(rest_s, run.latency_s))
        least = 1
    if handover.fault is not None and handover.left and not handover.ready:
        raise handover.fault
    return handover.take()
