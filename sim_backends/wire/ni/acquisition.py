"""One started counter: from sync edges and photons to samples in a buffer (h10682-daq.md 4.2 to 4.4 and 4.7)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from protocols import Floats, Integers
from sim_backends.bench import OpticalBench
from sim_backends.wire.ni.errors import CI_OVERRUN, STOPPED_TO_PREVENT_OVERWRITE, Manner
from sim_backends.wire.ni.settings import LatchRace, NiEmulatorSettings, ReadFault, ServerVanishes, Unplugged
from sim_backends.wire.seen_edges import SeenEdges

_WRAP = 2**32


@dataclass(frozen=True)
class Plan:
    """What a task is started with."""

    counter: str
    """Name of the counter, such as ``ctr0``."""

    tick_hz: float | None
    """Rate of the onboard timebase that is counted; None: a pin is."""

    photons: bool
    """Whether the head's pulses reach the counter."""

    clocked: bool
    """Whether the modulator's edges reach the sample clock."""

    arm: Literal["now", "edge", "sequence", "never"]
    """Armed at the start, by a sync edge, by the first edge of a sequence, or by a line on which nothing happens."""

    initial: int
    """Count at arming."""

    down: bool
    """Whether the counter counts down."""

    keeps_duplicates: bool
    """Duplicate count prevention: whether a sample without a source edge since the last one is written."""

    samples: int | None
    """Number of samples that a finite task takes; None: continuous."""

    capacity: int
    """Size of the input buffer, in samples."""

    overwrite: bool
    """Whether unread samples of a continuous task may be overwritten."""


@dataclass(frozen=True)
class Break:
    """What ended an acquisition before its time."""

    code: int
    manner: Manner = "metadata"
    gone: Literal["board", "server"] | None = None


class Acquisition:
    """The counter and its buffer, from arming on. It is told the time, and never waits."""

    def __init__(self, settings: NiEmulatorSettings, bench: OpticalBench, plan: Plan, now_s: float) -> None:
        self.plan = plan
        self.broken: Break | None = None
        self.overwritten = False
        self.acquired = 0
        self.position = 0
        self._settings = settings
        self._edges = SeenEdges(bench, now_s)
        self._armed_s = now_s if plan.arm == "now" else None
        self._photons = settings.counts_before_first_edge if plan.arm == "now" else 0
        self._last = 0
        self._fresh = True
        self._edge_s: float | None = None
        self._merged_until_s: float | None = None
        self._wraps_told = 0
        self._unread: NDArray[np.uint32] = np.zeros(0, np.uint32)
        self._fault = self._first_fault()

    def _first_fault(self) -> ReadFault | Unplugged | ServerVanishes | None:
        ends = (
            fault
            for fault in self._settings.faults
            if isinstance(fault, Unplugged | ServerVanishes)
            or (isinstance(fault, ReadFault) and fault.counter in (None, self.plan.counter))
        )
        return min(ends, key=lambda fault: fault.at, default=None)

    @property
    def available(self) -> int:
        """Samples that can be read."""
        return len(self._unread)

    @property
    def finished(self) -> bool:
        """Whether a finite acquisition has all of its samples."""
        return self.plan.samples is not None and self.acquired >= self.plan.samples

    @property
    def ended(self) -> bool:
        """Whether no sample will come any more."""
        return self.finished or self.broken is not None

    def time_of(self, n: int, until_s: float) -> float | None:
        """When ``n`` more samples may be there, or the acquisition breaks; None: not until ``until_s``."""
        if not self.plan.clocked or self.plan.arm == "never":
            return None
        if self._fault is not None:
            n = min(n, self._fault.at - self.acquired + 1)
        return self._edges.time_of(max(1, n), until_s)

    def look(self, now_s: float) -> None:
        """Take in what happened until ``now_s``."""
        if self.ended or self.plan.arm == "never":
            return
        time_s, photons = self._edges.take(now_s)
        if len(time_s):
            glitch = self._glitch(time_s)
            values = self._values(time_s[:glitch], photons[:glitch])
            if self.plan.clocked:
                self._store(values)
                if glitch is not None and not self.ended:
                    self.broken = Break(CI_OVERRUN, "bare")

    def _glitch(self, time_s: Floats) -> int | None:
        """Which of these edges comes too soon after the one before."""
        gap_s = np.diff(time_s, prepend=-np.inf if self._edge_s is None else self._edge_s)
        self._edge_s = float(time_s[-1])
        early = np.flatnonzero(gap_s < self._settings.min_sample_gap_s)
        return int(early[0]) if len(early) else None

    def _values(self, time_s: Floats, photons: Integers) -> Integers:
        """Counts since arming at each edge that gives a sample, not yet wrapped."""
        keep = np.ones(len(time_s), np.bool_)
        if not len(time_s):
            return np.zeros(0, np.int64)
        if self._armed_s is None:
            self._armed_s = float(time_s[0])
            keep[0] = self.plan.arm == "sequence" or self._settings.arm_edge_sampled
        elif self._fresh:
            keep[0] = self._settings.first_edge_sampled
        self._fresh = False
        total = self._photons + np.cumsum(self._merged(time_s, photons))
        self._photons = int(total[-1])
        count = self._count(time_s, total)
        if not self.plan.keeps_duplicates:
            keep &= np.diff(count, prepend=self._last) != 0
        self._last = int(count[-1])
        return count[keep]

    def _merged(self, time_s: Floats, photons: Integers) -> Integers:
        """Source edges of the photons of each bin, which arrive at any moment of it: pairs that are too close are one.

        Of n photons in a time T each neighbour follows within t with 1 - (1 - t / T)^n. The draws follow from the counts.
        """
        within_s = self._settings.merge_within_s
        if within_s == 0 or not len(photons):
            return photons
        before_s = time_s[0] if self._merged_until_s is None else self._merged_until_s
        self._merged_until_s = float(time_s[-1])
        bin_s = np.diff(time_s, prepend=before_s)
        near = 1 - (1 - np.minimum(1.0, within_s / np.maximum(bin_s, within_s))) ** np.maximum(photons, 1)
        pairs = np.where(bin_s > 0, np.maximum(photons - 1, 0), 0)
        lost: Integers = np.random.default_rng([len(photons), self._photons]).binomial(pairs, near)
        return photons - lost

    def _count(self, time_s: Floats, photons: Integers) -> Integers:
        """What the counter has counted at ``time_s``, when ``photons`` have come."""
        if self.plan.tick_hz is not None:
            rate_hz = self.plan.tick_hz * (1 + self._settings.timebase_ppm * 1e-6)
            ticks = np.floor((time_s - (self._armed_s or 0.0)) * rate_hz + self._settings.timebase_phase)
            return ticks.astype(np.int64)
        return photons if self.plan.photons else np.zeros(len(time_s), np.int64)

    def _register(self, count: Integers) -> NDArray[np.uint32]:
        """Counts as the 32-bit register shows them."""
        return ((self.plan.initial + (-count if self.plan.down else count)) % _WRAP).astype(np.uint32)

    def _store(self, count: Integers) -> None:
        """Put samples into the buffer, up to the end of the run, a fault, or the end of the buffer."""
        room = len(count)
        if self.plan.samples is not None:
            room = min(room, self.plan.samples - self.acquired)
        if self._fault is not None and self.acquired + room > self._fault.at:
            room = self._fault.at - self.acquired
            self.broken = self._break(self._fault)
        new = count[:room].copy()
        for fault in self._settings.faults:
            if isinstance(fault, LatchRace) and 0 <= fault.at - self.acquired < room and self.plan.photons:
                new[fault.at - self.acquired] -= fault.counts
        self._unread = np.concatenate([self._unread, self._register(new)])
        self.acquired += room
        self._overflow()

    @staticmethod
    def _break(fault: ReadFault | Unplugged | ServerVanishes) -> Break:
        match fault:
            case ReadFault():
                return Break(fault.code, fault.give)
            case Unplugged():
                return Break(fault.code, gone="board")
            case ServerVanishes():
                return Break(0, gone="server")

    def _overflow(self) -> None:
        surplus = self.available - self.plan.capacity
        if surplus <= 0 or self.plan.samples is not None:
            return
        if self.plan.overwrite:
            self.overwritten = True
            return
        self.acquired -= surplus
        self._unread = self._unread[: self.plan.capacity] if self._settings.readable_after_overrun else self._unread[:0]
        self.broken = Break(STOPPED_TO_PREVENT_OVERWRITE)

    def read(self, n: int) -> NDArray[np.uint32]:
        """Hand over the ``n`` oldest samples."""
        taken, self._unread = self._unread[:n], self._unread[n:]
        self.position += n
        return taken

    def count_now(self, now_s: float) -> int:
        """The live register; photons are seen bin by bin."""
        if self._armed_s is None:
            return self.plan.initial % _WRAP
        return int(self._register(self._count(np.array([now_s]), np.array([self._photons])))[0])

    def wrapped(self, now_s: float) -> bool:
        """Whether the register has passed its end since this was last asked."""
        if self._armed_s is None:
            return False
        count = int(self._count(np.array([now_s]), np.array([self._photons]))[0])
        wraps = abs((self.plan.initial + (-count if self.plan.down else count)) // _WRAP)
        told, self._wraps_told = self._wraps_told, wraps
        return wraps > told
