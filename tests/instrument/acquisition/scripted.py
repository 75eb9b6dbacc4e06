"""Devices that do what a script says, and a host that notes what it is told: for one run without a bench."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from instrument.acquisition import AlignedBlock, Devices, Phase
from protocols import (
    CountBlock,
    CounterLimits,
    CounterReport,
    CounterRun,
    DeviceIdentity,
    KinopixError,
    ModulatorLimits,
    ModulatorTiming,
    Motion,
    MotionProfile,
    PatternSequence,
    StageLimits,
    StagePosition,
    UploadProgress,
)

PERIOD_S = 50e-6


@dataclass
class Clock:
    """Time passes only by sleeping."""

    time_s: float = 0.0
    pauses_s: list[float] = field(default_factory=list[float])

    def now_s(self) -> float:
        return self.time_s

    def sleep_s(self, duration_s: float) -> None:
        self.pauses_s.append(duration_s)
        self.time_s += duration_s


class Device:
    """Who each device is, and a log that all of them share."""

    def __init__(self, name: str, log: list[str]) -> None:
        self.identity = DeviceIdentity(name=name, vendor="none", model="scripted")
        self.log = log

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.log.append(f"close {self.identity.name}")


class Modulator(Device):
    """Keeps 2 us more than it is asked for, and plays until it is told otherwise."""

    limits = ModulatorLimits(
        columns=64,
        rows=64,
        shortest_picture_time_us=44,
        longest_picture_time_us=1000,
        unique_patterns=100,
        play_order_entries=1000,
    )
    playing = False
    broken = False
    waited_s = 0.0

    @property
    def running(self) -> bool:
        if self.broken:
            raise KinopixError(saw="nothing", expected="an answer", remedy="look")
        return self.playing

    def load(
        self, sequence: PatternSequence, timing: ModulatorTiming, progress: UploadProgress | None = None
    ) -> ModulatorTiming:
        self.log.append(f"load {len(sequence.planes)} at {timing.picture_time_us} us")
        if progress is not None:
            progress(1, len(sequence.planes))
        return timing.model_copy(update={"picture_time_us": timing.picture_time_us + 2})

    def start(self) -> None:
        self.log.append("start")

    def wait(self, timeout_s: float) -> None:
        self.log.append("wait")
        self.waited_s = timeout_s

    def halt(self) -> None:
        self.log.append("halt")


class Counter(Device):
    """Hands over the blocks of its script, then nothing."""

    limits = CounterLimits(max_sync_rate_hz=1e6, max_count_rate_hz=5e6, dead_time_s=0.0)

    def __init__(self, name: str, log: list[str], blocks: list[CountBlock]) -> None:
        super().__init__(name, log)
        self.blocks = blocks
        self.armed: CounterRun | None = None
        self.timeouts_s: list[float] = []
        self.disarms_with: Exception | None = None
        self.wait_s: Callable[[float], object] = lambda _duration_s: None
        self._given = 0

    def arm(self, run: CounterRun) -> None:
        self.log.append("arm")
        self.armed = run

    def read(self, timeout_s: float) -> CountBlock:
        self.timeouts_s.append(timeout_s)
        block = self.blocks.pop(0) if self.blocks else CountBlock(self._given, np.empty(0, np.uint32))
        if not len(block):
            self.wait_s(timeout_s)
        self._given = block.first_bin + len(block)
        return block

    def disarm(self) -> CounterReport:
        self.log.append("disarm")
        if self.disarms_with is not None:
            raise self.disarms_with
        return CounterReport(bins_closed=self._given)


@dataclass
class Move:
    """A motion that ends when it is waited for."""

    target_mm: float
    log: list[str]
    done: bool = False

    def wait(self, timeout_s: float | None = None) -> StagePosition:
        self.log.append(f"at {self.target_mm:g}")
        self.done = True
        return StagePosition(time_s=0.0, commanded_mm=self.target_mm, reported_mm=self.target_mm)

    def stop(self) -> None:
        self.log.append("stop")


class Stage(Device):
    """Goes where it is sent."""

    limits = StageLimits(travel_mm=(0.0, 400.0), max_velocity_mm_s=50.0, max_acceleration_mm_s2=200.0)
    homed = True
    stands_by_s = 0.0

    def check(self, target_mm: float, profile: MotionProfile) -> None:
        self.limits.check_target(target_mm, "stage")

    def position(self) -> StagePosition:
        return StagePosition(time_s=0.0, commanded_mm=0.0, reported_mm=0.0)

    def move_to(self, target_mm: float, profile: MotionProfile) -> Motion:
        self.log.append(f"to {target_mm:g} at {profile.velocity_mm_s:g} mm/s")
        return Move(target_mm, self.log)

    def move_by(self, distance_mm: float, profile: MotionProfile) -> Motion:
        return self.move_to(distance_mm, profile)

    def home(self) -> Motion:
        return self.move_to(0.0, MotionProfile(velocity_mm_s=1, acceleration_mm_s2=1))

    def stop(self) -> None:
        self.log.append("stop")


class Host:
    """Notes all that it is told, and ends the run at a checkpoint where it is told to."""

    def __init__(self, log: list[str], end_at: int | None = None) -> None:
        self.log = log
        self.raw_blocks: list[CountBlock] = []
        self.placed_blocks: list[AlignedBlock] = []
        self.checkpoints = 0
        self._end_at = end_at

    def phase(self, phase: Phase) -> None:
        self.log.append(phase)

    def uploaded(self, stored: int, total: int) -> None:
        self.log.append(f"uploaded {stored} of {total}")

    def raw(self, block: CountBlock) -> None:
        self.raw_blocks.append(block)

    def placed(self, block: AlignedBlock) -> None:
        assert len(self.raw_blocks) == len(self.placed_blocks) + 1, "stored as it came before anything is made of it"
        self.placed_blocks.append(block)

    def checkpoint(self) -> None:
        self.checkpoints += 1
        if self.checkpoints == self._end_at:
            raise InterruptedError("asked to end")

    def broke(self) -> None:
        self.log.append("broke")


class Bench:
    """All of it, with one log."""

    def __init__(self, *blocks: CountBlock, end_at: int | None = None) -> None:
        self.log: list[str] = []
        self.clock = Clock()
        self.modulator = Modulator("dmd", self.log)
        self.counter = Counter("pmt", self.log, list(blocks))
        self.counter.wait_s = self.clock.sleep_s
        self.stage = Stage("stage", self.log)
        self.host = Host(self.log, end_at)
        self.devices = Devices.of(
            {"modulator": self.modulator, "counter": self.counter, "stage": self.stage}, clock=self.clock
        )


def bins(first: int, count: int, *, timed: bool = True) -> CountBlock:
    """Bins of 10 counts, at their nominal times."""
    counts = np.full(count, 10, np.uint32)
    if not timed:
        return CountBlock(first, counts)
    edges = np.arange(first, first + count + 1, dtype=np.float64) * PERIOD_S
    return CountBlock(first, counts, edges[:-1], float(edges[-1]))
