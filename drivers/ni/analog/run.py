"""One run on two analogue inputs: from arming to what is known when it is over."""

import math
from collections.abc import Callable
from typing import Final

import numpy as np

from drivers.h10682.detector import NAME
from drivers.h10682.handover import collect
from drivers.ni.analog.integrator import Integrated, Integrator
from drivers.ni.analog.settings import NiAnalogSettings
from drivers.ni.analog.tasks import AnalogInput, AnalogSystem, AnalogTask
from drivers.ni.errors import NiFault, Progress, typed_error
from protocols import Clock, CountBlock, CounterReport, CounterRun, Floats, KinopixError, Mask

_OVERLOAD: Final = 0.99
"""Part of the range from which on a sample counts as overloaded."""

_LARGEST_READ: Final = 100_000
"""Samples a channel of one read: a gRPC message holds more."""


class _Values:
    """Values that the caller has still to get. Satisfies ``drivers.h10682.handover.Bins``."""

    def __init__(self, n_bins: int) -> None:
        self.fault: KinopixError | None = None
        self.handed_over = 0
        self._n_bins = n_bins
        self._values: Floats = np.empty(0)
        self._suspect: Mask = np.empty(0, np.bool_)
        self._edges_s: Floats = np.empty(0)

    @property
    def left(self) -> int:
        """Bins of the run that the caller has not got yet."""
        return self._n_bins - self.handed_over

    @property
    def ready(self) -> int:
        """Bins that ``take`` would give now."""
        return min(self.left, len(self._values))

    def add(self, values: Floats, edges_s: Floats, suspect: Mask) -> None:
        """Put in ``(n,)`` values and their ``(n + 1,)`` edges, of which the first is the last of the call before."""
        self._values = np.concatenate([self._values, values])
        self._suspect = np.concatenate([self._suspect, suspect])
        self._edges_s = np.concatenate([self._edges_s, edges_s[1:]]) if len(self._edges_s) else edges_s

    def take(self) -> CountBlock:
        """Give all that is ready."""
        n, first = self.ready, self.handed_over
        self.handed_over += n
        block = CountBlock(
            first_bin=first,
            counts=self._values[:n],
            opening_edge_s=self._edges_s[:n],
            closing_edge_s=float(self._edges_s[n]) if n else None,
            suspect=self._suspect[:n],
        )
        self._values, self._suspect, self._edges_s = self._values[n:], self._suspect[n:], self._edges_s[n:]
        return block


class AnalogRun:
    """The inputs from arming to disarming. Satisfies ``drivers.h10682.counter.BoardRun``."""

    def __init__(self, run: CounterRun, settings: NiAnalogSettings, system: AnalogSystem, clock: Clock) -> None:
        """Configure and start the task, or nothing."""
        self._run, self._settings, self._clock = run, settings, clock
        self._values = _Values(run.n_bins)
        self._first_edge: int | None = None
        self._overloaded = 0
        self._integrator = Integrator(
            high_v=settings.sync_threshold_v,
            low_v=settings.sync_threshold_v - settings.sync_hysteresis_v,
            settle_samples=settings.settle_samples,
            limit_v=_OVERLOAD * settings.range_v,
        )
        asked = AnalogInput(
            channels=(f"{settings.device}/{settings.signal_channel}", f"{settings.device}/{settings.sync_channel}"),
            terminal=settings.terminal,
            range_v=settings.range_v,
            rate_hz=settings.sample_rate_hz,
            buffer_samples=math.ceil(max(settings.buffer_s, 4 * run.latency_s) * settings.sample_rate_hz),
        )
        task: AnalogTask | None = None
        try:
            task = system.sample(asked)
            task.start()
        except NiFault as fault:
            if task is not None:
                _failure(task.close)
            raise typed_error(fault, device=NAME, progress=Progress(bins_expected=run.n_bins)) from fault
        self._task = task
        self._rate_hz = task.rate_hz

    def read(self, timeout_s: float) -> CountBlock:
        """Hand over the bins that have closed; as ``PhotonCounter.read``."""
        return collect(self._values, self._poll, run=self._run, clock=self._clock, timeout_s=timeout_s)

    def finish(self) -> CounterReport:
        """Stop the task; tell the edges, the noise and the overloads. What fails becomes a note."""
        notes: list[str] = []
        if self._values.fault is not None and self._values.left:
            notes.append(f"the run broke off: {self._values.fault}")
        else:
            self._poll(0)  # edges that came after the last read
        noise_v, sample_v = self._integrator.value_noise_v, self._integrator.sample_noise_v
        if noise_v is not None and sample_v is not None:
            notes.append(
                f"values are in volts; noise of one {noise_v:.3g} V, of a sample {sample_v:.3g} V, if it is white"
            )
        if self._overloaded:
            notes.append(
                f"{self._overloaded} bins reached {_OVERLOAD:.0%} of the range of {self._settings.range_v:g} V"
            )
        notes.extend(failure for step in (self._task.stop, self._task.close) if (failure := _failure(step)))
        return CounterReport(
            bins_closed=self._values.handed_over, edges_seen=self._integrator.edges_seen, notes=tuple(notes)
        )

    def _poll(self, _least: int) -> None:
        try:
            waiting = self._task.available()
        except NiFault as fault:
            self._fail(fault)
            return
        while waiting > 0:
            got = self._task.read(min(waiting, _LARGEST_READ))
            self._take(self._integrator.feed(self._signal(got.samples_v[0]), got.samples_v[1]))
            if got.fault is not None:
                self._fail(got.fault)
                return
            waiting -= _LARGEST_READ

    def _signal(self, samples_v: Floats) -> Floats:
        return samples_v if self._settings.polarity == "positive" else -samples_v

    def _take(self, closed: Integrated) -> None:
        if not len(closed.values_v):
            return
        if self._first_edge is None:
            self._first_edge = int(closed.edges[0])
        self._overloaded += int(closed.overloaded.sum())
        offset_v = self._settings.offset_v if self._settings.polarity == "positive" else -self._settings.offset_v
        edges_s = (closed.edges - self._first_edge) / self._rate_hz
        self._values.add(closed.values_v - offset_v, edges_s, closed.overloaded)

    def _fail(self, fault: NiFault) -> None:
        progress = Progress(bins_read=self._values.handed_over + self._values.ready, bins_expected=self._run.n_bins)
        self._values.fault = self._values.fault or typed_error(fault, device=NAME, progress=progress)


def _failure(step: Callable[[], None]) -> str | None:
    """Run one step of letting go; what it raises becomes a sentence, so that the next step is still taken."""
    try:
        step()
    except NiFault as fault:
        return f"while disarming: {fault.text}"
    return None
