"""One run on NI counters: from arming, through reading, to what is known when it is over."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from drivers.h10682.detector import NAME
from drivers.h10682.handover import Handover, collect
from drivers.ni.errors import NiFault, Progress, typed_error
from drivers.ni.samples import SampledCounter
from drivers.ni.settings import NiSettings
from drivers.ni.tasks import EdgeCount, NiSystem
from protocols import Clock, CountBlock, CounterReport, CounterRun, TimingFault

_SMALLEST_BUFFER = 10_000
_CLOCK_RATE_MARGIN = 1.25
_BACKLOG_WARNING = 0.25


class NiRun:
    """The counters from arming to disarming."""

    def __init__(self, run: CounterRun, settings: NiSettings, system: NiSystem, clock: Clock) -> None:
        """Reserve, configure and start all counters, or none."""
        self._run = run
        self._clock = clock
        self._armed_s = clock.now_s()
        self._buffer = max(_SMALLEST_BUFFER, math.ceil(max(settings.buffer_s, 4 * run.latency_s) / run.period_s))
        self._handover = Handover(run.n_bins, 1 / settings.timebase_hz if settings.edge_counter else None)
        self._edges: SampledCounter | None = None
        self._shifted = False
        counters: list[SampledCounter] = []
        tasks = _tasks(settings)
        at = tasks[0]
        try:
            photons = SampledCounter(system.edge_count(self._photon_count(settings)))
            counters.append(photons)
            if settings.edge_counter is not None:
                at = tasks[1]
                self._edges = SampledCounter(system.edge_count(self._tick_count(settings, settings.edge_counter)))
                counters.append(self._edges)
            for task, counter in zip(tasks, counters, strict=True):
                at = task
                counter.task.start()
        except BaseException as fault:
            for counter in counters:
                _failure(counter.task.close)
            if isinstance(fault, NiFault):
                raise typed_error(fault, device=NAME, progress=Progress(bins_expected=run.n_bins, task=at)) from fault
            raise
        self._photons = photons

    def read(self, timeout_s: float) -> CountBlock:
        """Hand over the bins that have closed; as ``PhotonCounter.read``."""
        block = collect(self._handover, self._poll, run=self._run, clock=self._clock, timeout_s=timeout_s)
        if not len(block) and self._handover.left and timeout_s >= self._run.latency_s:
            self._compare()
            if self._handover.fault is not None:
                raise self._handover.fault  # nothing good is left to hand over first
        return block

    def finish(self) -> CounterReport:
        """Stop and free the counters; what fails becomes a note."""
        notes = self._handover.notes
        edges_seen = self._edges_seen(notes)
        self._ask_for_doubts(notes)
        backlog = self._photons.worst_backlog / self._buffer
        if backlog > _BACKLOG_WARNING:
            notes.append(f"at worst {backlog:.0%} of the host's buffer waited to be read: raise buffer_s")
        for counter in self._counters:
            for step in (counter.task.stop, counter.task.close):
                failure = _failure(step)
                if failure:
                    notes.append(failure)
        return CounterReport(
            bins_closed=self._handover.handed_over, edges_seen=edges_seen, shifted=self._shifted, notes=tuple(notes)
        )

    @property
    def _counters(self) -> list[SampledCounter]:
        return [self._photons] if self._edges is None else [self._photons, self._edges]

    def _photon_count(self, settings: NiSettings) -> EdgeCount:
        return self._edge_count(settings, settings.counter, settings.photon_terminal, settings.prevent_duplicates)

    def _tick_count(self, settings: NiSettings, counter: str) -> EdgeCount:
        # Between two sync edges there are always ticks, and duplicate-count prevention wants a source of 20 MHz or less.
        return self._edge_count(settings, counter, settings.timebase, prevent_duplicates=False)

    def _edge_count(self, settings: NiSettings, counter: str, source: str, prevent_duplicates: bool) -> EdgeCount:  # noqa: FBT001
        return EdgeCount(
            counter=f"{settings.device}/{counter}",
            source=settings.line(source),
            clock=settings.line(settings.sync_terminal),
            clock_edge=settings.sync_edge,
            max_rate_hz=_CLOCK_RATE_MARGIN / self._run.period_s,
            buffer_samples=self._buffer,
            prevent_duplicates=prevent_duplicates,
            clock_filter_s=settings.sync_filter_s,
            arm=None if settings.arm_terminal is None else settings.line(settings.arm_terminal),
        )

    def _poll(self, least: int) -> None:
        """Read what waits. ``least`` above 1 is the first look at a block: too little is left in the buffer."""
        # The edge counter is asked first: an edge that comes in between then shows in the photons at least.
        waiting = {counter: counter.waiting() for counter in reversed(self._counters)}
        least_samples = least if self._photons.first_sample_seen else least + 1
        if least > 1 and not self._faults and min(waiting.values()) < least_samples:
            return
        # An empty buffer is read too, for some faults come to light only by a read.
        self._take_in(lambda counter: counter.differences(max(1, waiting[counter])))
        if self._faults:
            self._take_in(SampledCounter.rest)
            self._handover.fail(typed_error(self._faults[0], device=NAME, progress=self._progress))

    def _take_in(self, read: Callable[[SampledCounter], NDArray[np.uint32]]) -> None:
        ticks = None if self._edges is None else read(self._edges).astype(np.int64)
        self._handover.add(read(self._photons), ticks)

    @property
    def _faults(self) -> list[NiFault]:
        return [counter.fault for counter in self._counters if counter.fault is not None]

    @property
    def _progress(self) -> Progress:
        return Progress(
            bins_read=self._handover.handed_over + self._handover.ready,
            bins_expected=self._run.n_bins,
            waited_s=self._clock.now_s() - self._armed_s,
        )

    def _compare(self) -> None:
        """No bin closed for a whole latency: the two counters must have stored the same number of samples by now."""
        if self._edges is None or self._edges.samples_read == self._photons.samples_read:
            return
        photons, edges = self._photons.samples_read, self._edges.samples_read
        fewer = "photon" if photons < edges else "edge"
        self._handover.fail(
            TimingFault(
                device=NAME,
                saw=f"{photons} samples of the photon counter for {edges} of the edge counter",
                expected="one sample of each for every sync edge",
                remedy=f"the {fewer} counter skips edges, so its bins have shifted: do not use this run; "
                "set prevent_duplicates = true, or use a board that stores bins without photons",
            )
        )

    def _edges_seen(self, notes: list[str]) -> int | None:
        totals: list[int] = []
        for counter in self._counters:
            try:
                totals.append(counter.task.acquired())
            except NiFault as fault:
                notes.append(f"surplus sync edges are unknown: {fault.text}")
                return None
        if max(totals) != min(totals):
            self._shifted = not self._faults
            notes.append(
                f"the photon counter stored {totals[0]} samples and the edge counter {totals[1]}: bins may have shifted"
            )
        return max(totals)

    def _ask_for_doubts(self, notes: list[str]) -> None:
        try:
            doubtful = self._photons.task.doubtful()
        except NiFault:
            return  # not every board knows; that it does not is no news about the run
        if doubtful:
            notes.append(f"the board calls {doubtful} samples possibly invalid")


def _tasks(settings: NiSettings) -> list[str]:
    """What each task is, in the order in which they are reserved; each names the other one too."""
    photons, edges = f"{settings.device}/{settings.counter}", f"{settings.device}/{settings.edge_counter}"
    if settings.edge_counter is None:
        return [f"the photon task on {photons}"]
    return [
        f"the photon task on {photons} (edge times: {edges})",
        f"the edge-time task on {edges} (photons: {photons})",
    ]


def _failure(step: Callable[[], None]) -> str | None:
    """Run one step of letting go; what it raises becomes a sentence, so that the next step is still taken."""
    try:
        step()
    except NiFault as fault:
        return f"while disarming: {fault.text}"
    return None
