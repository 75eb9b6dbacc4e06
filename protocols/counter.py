"""Photon counters that sort counts into one bin a pattern, by the modulator's sync edges.

**The N + 1 edge rule.** A bin opens at one sync edge and closes at the next: the first edge after ``arm`` opens bin 0, and N
bins need N + 1 edges. What was counted between arming and the first edge is never data and is never handed over.
"""

from dataclasses import dataclass
from typing import Protocol, Self, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from pydantic import NonNegativeFloat, NonNegativeInt, PositiveFloat, PositiveInt

from protocols.values import DeviceIdentity, Floats, Frozen, Mask

Counts: TypeAlias = NDArray[np.uint32] | NDArray[np.float64]
"""Photon counts as uint32; float64 only from a simulated detector that does not count photons."""


class CounterLimits(Frozen):
    """What a counter and its detector can do."""

    max_sync_rate_hz: PositiveFloat
    """Highest rate of sync edges."""

    max_count_rate_hz: PositiveFloat
    """Count rate above which the counts are no longer linear (data sheet: 10 % loss)."""

    dead_time_s: NonNegativeFloat
    """Non-paralyzable dead time of detector and counter together; 0 where there is none."""

    dark_rate_hz: NonNegativeFloat = 0.0
    """Dark counts a second, as measured or from the data sheet; 0 where unknown."""

    max_bins: PositiveInt | None = None
    """Bins a run at most; None where a run may go on for ever."""

    edge_time_resolution_s: PositiveFloat | None = None
    """Step of the hardware's edge times; None where the board gives no edge times."""


class CounterRun(Frozen):
    """What a counter is armed for."""

    n_bins: PositiveInt
    """Patterns to count: the run ends when so many bins are closed."""

    period_s: PositiveFloat
    """Expected time between sync edges."""

    latency_s: PositiveFloat = 0.05
    """How long counts may wait in the device: the driver picks its block size by it."""


@dataclass(frozen=True, eq=False)
class CountBlock:
    """Bins that closed since the last block, in hardware order, none twice, none left out."""

    first_bin: int
    """Hardware index of the first bin, from 0: the device's sample count, not the order of arrival at the host."""

    counts: Counts
    """``(n,)``: light of each bin."""

    opening_edge_s: Floats | None = None
    """``(n,)``: hardware time of each bin's opening edge, relative to the run's first edge; None without edge times."""

    closing_edge_s: float | None = None
    """Hardware time of the edge that closed the last bin of this block."""

    suspect: Mask | None = None
    """``(n,)``: True where the hardware itself doubts the count; None where it never says."""

    def __len__(self) -> int:
        """Bins in this block."""
        return len(self.counts)


class CounterReport(Frozen):
    """What the counter knows about a run when it is over."""

    bins_closed: NonNegativeInt
    """Bins handed over."""

    edges_seen: NonNegativeInt | None = None
    """Sync edges from arming to disarming, surplus ones too; None where the board cannot tell."""

    shifted: bool = False
    """True where bins may belong to other edges than the ones they were handed over with: nothing of the run can be trusted."""

    notes: tuple[str, ...] = ()
    """What a person should know: a filter that is set, a doubtful sample, a lost packet."""


@runtime_checkable
class PhotonCounter(Protocol):
    """Counts pulses between sync edges.

    Life: ``arm`` -> ``read`` until ``n_bins`` are in -> ``disarm``. ``arm`` may follow ``disarm`` any number of times.
    ``disarm`` is allowed at any time and twice. As a context manager it is open from construction on.

    **No count is lost to an error**: when something breaks, ``read`` first hands over all that is good and raises only when
    called again with nothing left to hand over.
    """

    @property
    def identity(self) -> DeviceIdentity:
        """Who the device is."""
        ...

    @property
    def limits(self) -> CounterLimits:
        """Rates, dead time, and whether there are edge times."""
        ...

    def arm(self, run: CounterRun) -> None:
        """Get ready for the first sync edge. Returns when an edge that comes now would be seen.

        Raises:
            WrongState: already armed.
            PlanError: faster or longer than ``limits`` allow.
        """
        ...

    def read(self, timeout_s: float) -> CountBlock:
        """Hand over the bins that have closed, about ``latency_s`` worth of them.

        Waits up to ``timeout_s`` for the first bin, and then no longer than about ``latency_s`` for more, so that the last
        bins of a run are not held back. Returns an empty block if none closed in that time, and at once when the run has all
        its ``n_bins``.

        Raises:
            CounterOverrun: counts were lost; those before are handed over already.
            DeviceDisconnected: the board is gone.
            WrongState: not armed.
        """
        ...

    def disarm(self) -> CounterReport:
        """Stop counting and tell what was seen. Never raises for a counter that is not armed."""
        ...

    def __enter__(self) -> Self:
        """Give the open device."""
        ...

    def __exit__(self, *exc: object) -> None:
        """Disarm and let go of the device, even if disarming fails."""
        ...
