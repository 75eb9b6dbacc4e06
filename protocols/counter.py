"""Photon counters that sort counts into one bin a pattern, by the modulator's sync edges.

**The N + 1 edge rule.** A bin opens at one sync edge and closes at the next: the first edge after ``arm`` opens bin 0, and N
bins need N + 1 edges. What was counted between arming and the first edge is never data and is never handed over.
"""

from dataclasses import dataclass
from typing import Protocol, Self, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from pydantic import NonNegativeFloat, NonNegativeInt, PositiveFloat, PositiveInt

from protocols.errors import PlanError, ProtocolViolation
from protocols.values import DeviceIdentity, Floats, Frozen, Mask

Counts: TypeAlias = NDArray[np.uint32] | NDArray[np.float64]
"""Photon counts as uint32; float64 only from a simulated detector that does not count photons."""

_ROUNDING = 1e-9
"""Relative excess of a rate over its limit that is no more than the rounding of 1 / period."""


class CounterLimits(Frozen):
    """Limits of a counter and its detector, and the checks of a run against them."""

    max_sync_rate_hz: PositiveFloat
    """Highest rate of sync edges that the counter follows, in Hz."""

    max_count_rate_hz: PositiveFloat
    """Highest count rate at which the counts are still linear, in counts a second (data sheet: 10 % loss)."""

    dead_time_s: NonNegativeFloat
    """Non-paralyzable dead time of detector and counter together, in seconds; 0 where there is none."""

    dark_rate_hz: NonNegativeFloat = 0.0
    """Dark counts a second, as measured or from the data sheet; 0 where unknown."""

    max_bins: PositiveInt | None = None
    """Largest number of bins in one run; None where a run may go on for ever."""

    edge_time_resolution_s: PositiveFloat | None = None
    """Step of the hardware's edge times, in seconds; None where the board gives no edge times."""

    max_unread_bins: PositiveInt | None = None
    """Number of bins that the device keeps while nobody reads, before some are lost; None where the host takes them in by itself
    and has room for some seconds of them."""

    def check_run(self, run: "CounterRun", device: str) -> None:
        """Refuse a run that is faster or longer than the counter; ``device`` is the name that the error carries.

        Raises:
            PlanError: too many sync edges a second, or too many bins; names what was asked and what is possible.
        """
        self.check_sync_rate(run.period_s, device)
        self.check_bins(run.n_bins, device)

    def check_sync_rate(self, period_s: float, device: str) -> None:
        """Refuse sync edges that come closer together than ``period_s`` seconds allow.

        Raises:
            PlanError: names both rates.
        """
        rate_hz = 1 / period_s
        if rate_hz > self.max_sync_rate_hz * (1 + _ROUNDING):
            raise PlanError(
                device=device,
                saw=f"{rate_hz:.6g} sync edges a second",
                expected=f"at most {self.max_sync_rate_hz:.6g}",
                remedy="lower pattern_rate_hz in plan.toml",
            )

    def check_bins(self, n_bins: int, device: str) -> None:
        """Refuse a run of more bins than the counter can count in one go.

        Raises:
            PlanError: names both numbers.
        """
        if self.max_bins is not None and n_bins > self.max_bins:
            raise PlanError(
                device=device,
                saw=f"a run of {n_bins} patterns",
                expected=f"at most {self.max_bins} patterns a run",
                remedy="record fewer frames a run",
            )


class CounterRun(Frozen):
    """Run that a counter is armed for."""

    n_bins: PositiveInt
    """Number of patterns to count: the run ends when so many bins are closed."""

    n_expected: PositiveInt | None = None
    """Number of bins that close where no edge is lost or surplus; None: ``n_bins``. A device that has to be told how much to
    send takes this; one that can go on takes ``n_bins``, which leaves room for bins that surplus edges split."""

    period_s: PositiveFloat
    """Expected time between sync edges, in seconds."""

    latency_s: PositiveFloat = 0.05
    """Time for which counts may wait in the device, in seconds: the driver picks its block size by it."""


@dataclass(frozen=True, eq=False)
class CountBlock:
    """Bins that closed since the last block, in hardware order, none twice, none left out.

    Raises:
        ProtocolViolation: the arrays do not agree with each other, or are not what their fields say.
    """

    first_bin: int
    """Hardware index of the first bin, from 0: the device's sample count, not the order of arrival at the host.

    The next block begins where this one ends, at ``first_bin + len(block)``. An empty block has the index of the bin that
    comes next. The acquisition refuses a block that begins elsewhere, for bins were then lost or repeated.
    """

    counts: Counts
    """``(n,)`` light of each bin: uint32 photon counts, or float64 from a detector that does not count photons."""

    opening_edge_s: Floats | None = None
    """``(n,)`` hardware time of each bin's opening edge, in seconds from the run's first edge; None without edge times."""

    closing_edge_s: float | None = None
    """Hardware time of the edge that closed the last bin, in seconds; given exactly where ``opening_edge_s`` has any."""

    suspect: Mask | None = None
    """``(n,)`` mask, True where the hardware itself doubts the count; None where it never says."""

    def __post_init__(self) -> None:
        """Refuse arrays that cannot be the counts of one block: a mistake of the driver, found before it spoils a run."""
        kind, shape = self.counts.dtype, self.counts.shape
        if len(shape) != 1 or kind not in _COUNT_KINDS:
            raise _bad_block(f"counts of shape {shape} and type {kind}", "(n,) of uint32 photons, or of float64")
        if self.first_bin < 0:
            raise _bad_block(f"first_bin = {self.first_bin}", "0 or more")
        if self.suspect is not None and (self.suspect.shape != shape or self.suspect.dtype != np.bool_):
            saw = f"a mask of shape {self.suspect.shape} and type {self.suspect.dtype}"
            raise _bad_block(f"{saw} for counts of shape {shape}", "one bool a bin")
        self._check_edges()

    def _check_edges(self) -> None:
        opening, closing = self.opening_edge_s, self.closing_edge_s
        if opening is not None and (opening.shape != self.counts.shape or opening.dtype != np.float64):
            saw = f"opening edges of shape {opening.shape} and type {opening.dtype}"
            raise _bad_block(f"{saw} for counts of shape {self.counts.shape}", "one float64 a bin")
        if (closing is None) == bool(opening is not None and len(opening)):
            saw = "opening edges without a closing edge" if closing is None else "a closing edge without opening edges"
            raise _bad_block(saw, "both, or neither")
        if opening is None or closing is None:
            return
        if not (opening[-1] <= closing and np.all(opening[1:] >= opening[:-1])):
            raise _bad_block(
                "edge times that are not numbers or go back", "times that never fall, the closing edge last"
            )

    def __len__(self) -> int:
        """Give the number of bins in this block."""
        return len(self.counts)

    @property
    def photon_counts(self) -> bool:
        """Whether the counts are whole photons (uint32), whose variance is known, or simulated light (float64)."""
        return self.counts.dtype == np.uint32


_COUNT_KINDS = (np.dtype(np.uint32), np.dtype(np.float64))


def _bad_block(saw: str, expected: str) -> ProtocolViolation:
    return ProtocolViolation(
        saw=f"a block of counts with {saw}",
        expected=expected,
        remedy="report this to the author of the counter's driver; its conformance suite should have found it",
    )


class CounterReport(Frozen):
    """Report of a counter on a run that is over."""

    bins_closed: NonNegativeInt
    """Number of bins handed over."""

    edges_seen: NonNegativeInt | None = None
    """Number of sync edges from arming to disarming, surplus ones too; None where the board cannot tell."""

    shifted: bool = False
    """True where bins may belong to other edges than the ones they were handed over with: nothing of the run can be trusted."""

    notes: tuple[str, ...] = ()
    """Sentences that a person should read: a filter that is set, a doubtful sample, a lost packet."""


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
        """Identity of the board and of the detector on it."""
        ...

    @property
    def limits(self) -> CounterLimits:
        """Highest rates, dead time, longest run, and whether there are edge times."""
        ...

    def arm(self, run: CounterRun) -> None:
        """Get ready for the first sync edge. Returns when an edge that comes now would be seen.

        Raises:
            WrongState: already armed.
            PlanError: faster or longer than ``limits`` allow (``CounterLimits.check_run``).
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
