"""NI-DAQmx as a script: each counter stores the samples it is told to, one at each sync edge, and breaks where it is told to."""

from dataclasses import dataclass, field

import numpy as np

from drivers.ni.errors import NiFault
from drivers.ni.tasks import EdgeCount, NiBoardFacts, NiRead, NiTask
from tests.drivers.h10682.clock import ScriptClock


@dataclass
class ScriptedTask:
    """A ``NiTask`` whose sample k is ``samples[k]`` and is there ``edges_s[k]`` after the start."""

    clock: ScriptClock
    samples: list[int]
    edges_s: list[float]
    breaks_after: int | None = None
    """So many samples are good; after them ``fault`` answers a read, or ``available`` where ``breaks_available``."""
    fault: NiFault = field(default_factory=lambda: NiFault("broken", -200361))
    breaks_available: bool = False
    fails: dict[str, NiFault] = field(default_factory=dict[str, NiFault])
    """Faults of the other calls, by name."""
    calls: list[str] = field(default_factory=list[str])
    reads: list[int] = field(default_factory=list[int])
    taken: int = 0
    started_s: float = 0.0

    def start(self) -> None:
        self._call("start")
        self.started_s = self.clock.now_s()

    def available(self) -> int:
        if self.breaks_available and self._broken:
            raise self.fault
        return self._there - self.taken

    def read(self, n: int) -> NiRead:
        self.reads.append(n)
        first = self.taken
        self.taken = min(self._there, first + n)
        samples = np.array(self.samples[first : self.taken], np.uint32)
        return NiRead(samples, self.fault if len(samples) < n and self._broken else None)

    def acquired(self) -> int:
        self._call("acquired")
        return self._there

    def doubtful(self) -> int:
        self._call("doubtful")
        return 0

    def stop(self) -> None:
        self._call("stop")

    def close(self) -> None:
        self._call("close")

    @property
    def _came(self) -> int:
        elapsed_s = self.clock.now_s() - self.started_s + 1e-12
        return min(len(self.samples), sum(edge_s <= elapsed_s for edge_s in self.edges_s))

    @property
    def _there(self) -> int:
        return self._came if self.breaks_after is None else min(self._came, self.breaks_after)

    @property
    def _broken(self) -> bool:
        return self.breaks_after is not None and self._came > self.breaks_after

    def _call(self, name: str) -> None:
        self.calls.append(name)
        if name in self.fails:
            raise self.fails[name]


X_SERIES = NiBoardFacts(
    product="PCIe-6323", serial="1A2B3C", simulated=False, sample_clocked_counting=True, counter_bits=32,
    max_timebase_hz=100e6, counters=("ctr0", "ctr1", "ctr2", "ctr3"),
)  # fmt: skip


@dataclass
class ScriptedNi:
    """A ``NiSystem`` that gives its tasks in order."""

    tasks: list[ScriptedTask | NiFault]
    one: NiBoardFacts | NiFault = X_SERIES
    counts: list[EdgeCount] = field(default_factory=list[EdgeCount])
    version: str = "nidaqmx 1.7.0, NI-DAQmx 24.5.0"

    def boards(self) -> tuple[str, ...]:
        return ("Dev1",)

    def board(self, name: str) -> NiBoardFacts:
        if isinstance(self.one, NiFault):
            raise self.one
        return self.one

    def edge_count(self, count: EdgeCount) -> NiTask:
        self.counts.append(count)
        task = self.tasks.pop(0)
        if isinstance(task, NiFault):
            raise task
        return task
