"""A simulated photon counter: hardware-gated bins with edge times, counting the optical bench's light."""

import math
from dataclasses import dataclass
from typing import Annotated, Self

import numpy as np
from pydantic import Field

from protocols import (
    BenchContext,
    CountBlock,
    CounterLimits,
    CounterOverrun,
    CounterReport,
    CounterRun,
    DeviceDisconnected,
    DeviceIdentity,
    DriverPlugin,
    Floats,
    Frozen,
    WrongState,
)
from sim_backends.bench import OpticalBench
from sim_backends.bench.bounds import DarkHertz, Hertz, Index, Instant, Number
from sim_backends.devices.place import place

_NAME = "pmt"

LAG_TOLD_S = 0.2
"""Time by which counts may come late, beyond their latency, before the report says so: what a busy machine does now and then."""


class CounterSettings(Frozen):
    """Keys of ``[counter]``. The defaults are those of an H10682 head on a board with hardware time stamps."""

    max_sync_rate_hz: Hertz = 1e6
    """Highest rate of sync edges, in Hz."""

    max_count_rate_hz: Hertz = 5e6
    """Count rate at which 10 % is lost (data sheet of the head)."""

    dead_time_s: Instant | None = None
    """Dead time that the counter believes in, in seconds; None: the scene's own, as if it had been calibrated."""

    dark_rate_hz: DarkHertz | None = None
    """Dark rate that the counter believes in, in counts a second; None: the scene's own."""

    max_bins: Number | None = None
    """Largest number of bins in one run; None: as many as are asked for."""

    edge_times: bool = True
    """Whether the board gives the time of each edge."""

    edge_time_resolution_s: Annotated[float, Field(ge=1e-15, le=1)] = 1e-8
    """Step of the edge times: a 100 MHz time base."""

    overrun_at_bin: Index | None = None
    """A fault: from this bin on, counts are lost in the device."""

    unplugged_at_bin: Index | None = None
    """A fault: the board is gone after this many bins."""

    lost_block_at_bin: Index | None = None
    """A fault: the block that holds this bin never reaches the host, and nothing tells but the index of the next one."""


@dataclass
class _Armed:
    """A run being counted."""

    run: CounterRun
    since_s: float
    done: int = 0
    first_edge: int | None = None
    first_edge_s: float = 0.0


class SimulatedCounter:
    """``protocols.PhotonCounter`` on the optical bench."""

    def __init__(self, settings: CounterSettings, bench: OpticalBench) -> None:
        self._settings = settings
        self._bench = bench
        self._armed: _Armed | None = None
        self._lag_s = 0.0
        self._closed = False

    @property
    def identity(self) -> DeviceIdentity:
        """Identity of the simulated device."""
        return DeviceIdentity(
            name=_NAME, vendor="Kinopix", model="simulated H10682 and counter", driver="simulated", simulated=True
        )

    @property
    def limits(self) -> CounterLimits:
        """Rates, dead time and edge times, as set."""
        settings, noise = self._settings, self._bench.settings.noise
        dead_s, dark_hz = (noise.dead_time_s, noise.dark_rate_hz) if noise.kind == "poisson" else (0.0, 0.0)
        return CounterLimits(
            max_sync_rate_hz=settings.max_sync_rate_hz,
            max_count_rate_hz=settings.max_count_rate_hz,
            dead_time_s=dead_s if settings.dead_time_s is None else settings.dead_time_s,
            dark_rate_hz=dark_hz if settings.dark_rate_hz is None else settings.dark_rate_hz,
            max_bins=settings.max_bins,
            edge_time_resolution_s=settings.edge_time_resolution_s if settings.edge_times else None,
        )

    def arm(self, run: CounterRun) -> None:
        """Get ready for the first sync edge; see ``protocols.PhotonCounter.arm``."""
        if self._closed or self._armed:
            raise WrongState(
                device=_NAME,
                saw="arming " + ("after the device was closed" if self._closed else "while armed"),
                expected="an open, idle counter",
                remedy="open it anew" if self._closed else "disarm it first",
            )
        self.limits.check_run(run, _NAME)
        self._armed, self._lag_s = _Armed(run, self._bench.clock.now_s()), 0.0

    def read(self, timeout_s: float) -> CountBlock:
        """Hand over about ``latency_s`` worth of closed bins; see ``protocols.PhotonCounter.read``."""
        armed = self._expect_armed()
        wanted = min(self._good_bins(armed), armed.done + max(1, round(armed.run.latency_s / armed.run.period_s)))
        if wanted == armed.done < armed.run.n_bins:
            self._break(armed)
        closed = self._wait(armed, wanted, self._bench.clock.now_s() + timeout_s)
        block = self._block(armed, min(closed, wanted))
        armed.done += len(block)
        self._see_lag(armed, len(block))
        lost = self._settings.lost_block_at_bin
        return self.read(timeout_s) if lost is not None and 0 <= lost - block.first_bin < len(block) else block

    def _good_bins(self, armed: _Armed) -> int:
        """Bins of this run that no fault spoils."""
        faults = (self._settings.overrun_at_bin, self._settings.unplugged_at_bin)
        return min([armed.run.n_bins, *(bins for bins in faults if bins is not None)])

    def _break(self, armed: _Armed) -> None:
        if self._settings.unplugged_at_bin == armed.done:
            raise DeviceDisconnected(
                device=_NAME,
                saw=f"no board any more after bin {armed.done}",
                expected="an answer",
                remedy="check the cable and the power of the counter board",
            )
        raise CounterOverrun(
            device=_NAME,
            saw=f"the counter's buffer full at bin {armed.done}",
            expected="a host that reads in time",
            remedy="read oftener, or lower pattern_rate_hz",
        )

    def _wait(self, armed: _Armed, wanted: int, deadline_s: float) -> int:
        """Let time pass until ``wanted`` bins have closed or the deadline is there; give how many have closed."""
        bench = self._bench
        if wanted > armed.done:
            self._find_first_edge(armed, deadline_s)
            until_s = deadline_s
            if armed.first_edge is not None:
                closing = bench.edges(armed.first_edge + armed.done + 1, deadline_s).time_s
                enough = wanted - armed.done
                if len(closing) >= enough:
                    until_s = float(closing[enough - 1])
                elif len(closing):
                    patience_s = bench.clock.now_s() + armed.run.latency_s
                    until_s = min(deadline_s, max(float(closing[0]), patience_s))
            bench.clock.advance_to(until_s)
        if armed.first_edge is None or armed.first_edge_s > bench.clock.now_s():
            return 0
        return max(0, len(bench.edges(armed.first_edge, bench.clock.now_s())) - 1)

    def _see_lag(self, armed: _Armed, bins: int) -> None:
        """Note how long ago the last bin that is handed over closed: in virtual time it never waits for its light."""
        if bins:
            closed_s = self._bench.edges((armed.first_edge or 0) + armed.done, math.inf).time_s[0]
            self._lag_s = max(self._lag_s, self._bench.clock.now_s() - float(closed_s))

    def _find_first_edge(self, armed: _Armed, until_s: float) -> None:
        if armed.first_edge is None:
            edges = self._bench.edges(0, until_s)
            seen = np.flatnonzero(edges.time_s >= armed.since_s)
            if len(seen):
                armed.first_edge = edges.first + int(seen[0])
                armed.first_edge_s = float(edges.time_s[seen[0]])

    def _block(self, armed: _Armed, closed: int) -> CountBlock:
        first, bench = armed.done, self._bench
        n = max(0, closed - first)
        edge = first + (armed.first_edge or 0)
        counts = bench.counts(edge, n)
        if not self._settings.edge_times:
            return CountBlock(first, counts)
        times_s = self._ticks(bench.edges(edge, math.inf).time_s[: n + 1] - armed.first_edge_s)
        return CountBlock(first, counts, times_s[:n], float(times_s[n]) if n else None)

    def _ticks(self, time_s: Floats) -> Floats:
        step_s = self._settings.edge_time_resolution_s
        ticks: Floats = np.rint(time_s / step_s) * step_s
        return ticks

    def _expect_armed(self) -> _Armed:
        if self._armed is None:
            raise WrongState(
                device=_NAME, saw="a read while not armed", expected="an armed counter", remedy="arm it first"
            )
        return self._armed

    def disarm(self) -> CounterReport:
        """Stop counting and tell what was seen."""
        armed, self._armed = self._armed, None
        if armed is None:
            return CounterReport(bins_closed=0)
        now_s = self._bench.clock.now_s()
        self._find_first_edge(armed, now_s)
        seen = 0 if armed.first_edge is None else len(self._bench.edges(armed.first_edge, now_s))
        late = self._lag_s > LAG_TOLD_S + armed.run.latency_s
        notes = (f"the simulated bench ran up to {self._lag_s:.1f} s behind real time",) if late else ()
        return CounterReport(bins_closed=armed.done, edges_seen=seen, notes=notes)

    def __enter__(self) -> Self:
        """Give the open device."""
        return self

    def __exit__(self, *exc: object) -> None:
        """Disarm and close."""
        self.disarm()
        self._closed = True


def open_counter(settings: CounterSettings, context: BenchContext) -> SimulatedCounter:
    """Open the simulated counter on the context's optical bench."""
    return SimulatedCounter(settings, place(context, _NAME))


plugin = DriverPlugin(
    summary="simulated photon counter on the optical bench", settings=CounterSettings, open=open_counter
)
"""Found as ``kinopix.counters: simulated``."""
