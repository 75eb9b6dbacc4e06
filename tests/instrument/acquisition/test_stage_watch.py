"""The stage is looked at while a run goes on, and no answer of it, nor a missing one, costs the run anything."""

import numpy as np
import pytest

from instrument.acquisition import Devices, acquire
from instrument.acquisition.stage_watch import StageWatch
from instrument.plan import MotionPlan, Plan
from protocols import CountBlock, DeviceTimeout, ModulatorTiming, StagePosition
from tests.instrument.acquisition.scripted import PERIOD_S, Bench, Clock, Counter, Stage, bins

MOVING = Plan(frames=4, image_size=8, motion=MotionPlan(velocity_mm_s=25.0, acceleration_mm_s2=250.0))
MUTE = DeviceTimeout("stage", awaited="a position", waited_s=0.5, progress="not a byte", remedy="look")


class Asked(Stage):
    """Is as many millimetres from 0 as its clock is old in seconds, until it fails."""

    def __init__(self, clock: Clock, error: Exception = MUTE, fails_at: int = 0) -> None:
        super().__init__("stage", [])
        self.clock = clock
        self.error = error
        self.fails_at = fails_at
        self.asked_at_s: list[float] = []

    def position(self) -> StagePosition:
        self.asked_at_s.append(self.clock.now_s())
        if len(self.asked_at_s) == self.fails_at:
            raise self.error
        return StagePosition(time_s=self.clock.now_s(), commanded_mm=9.0, reported_mm=self.clock.now_s())


def looked(stage: Asked, clock: Clock, *, unread_s: float) -> StageWatch:
    """Before the run, and every 0.04 s of a run that lasts 0.4 s."""
    watch = StageWatch(stage, clock, unread_s=unread_s)
    watch.look()
    clock.sleep_s(1.0)
    watch.started()
    for _ in range(10):
        clock.sleep_s(0.04)
        watch.look_again()
    return watch


def test_a_look_is_taken_each_tenth_of_a_second() -> None:
    """Blocks come every 0.04 s: the first that is 0.1 s or more behind the last look is the third, each time."""
    clock = Clock()
    log = looked(stage := Asked(clock), clock, unread_s=2.0).log
    np.testing.assert_allclose(stage.asked_at_s, [0.0, 1.12, 1.24, 1.36])
    assert log is not None
    np.testing.assert_allclose(log.time_s, [-1.0, 0.12, 0.24, 0.36])
    np.testing.assert_allclose(log.reported_mm, [0.0, 1.12, 1.24, 1.36])


def test_nothing_is_asked_while_a_counter_counts_that_a_silent_stage_could_make_overrun() -> None:
    """A USB-CTR keeps 4096 counts: 0.2 s of 20,000 a second, and a stage may leave a question open for up to 2 s."""
    clock = Clock()
    log = looked(stage := Asked(clock), clock, unread_s=1.99).log
    assert stage.asked_at_s == [0.0]
    assert log is not None
    assert log.time_s.tolist() == [-1.0]


@pytest.mark.parametrize("error", [MUTE, RuntimeError("of a library below the driver")])
def test_a_stage_that_fails_is_asked_no_more(error: Exception) -> None:
    clock = Clock()
    log = looked(stage := Asked(clock, error, fails_at=3), clock, unread_s=10.0).log
    assert len(stage.asked_at_s) == 3
    assert log is not None
    np.testing.assert_allclose(log.time_s, [-1.0, 0.12])


class Slow(Counter):
    """Takes a tenth of a second for a block."""

    def __init__(self, bench: Bench, blocks: list[CountBlock], kept: int | None) -> None:
        super().__init__("pmt", bench.log, blocks)
        self.limits = self.limits.model_copy(update={"max_unread_bins": kept})
        self.clock = bench.clock

    def read(self, timeout_s: float) -> CountBlock:
        self.clock.sleep_s(0.1)
        return super().read(timeout_s)


@pytest.mark.parametrize(("kept_s", "asked"), [(None, 4), (2.1, 4), (1.9, 1)])
@pytest.mark.parametrize("fails_at", [0, 1, 2, 4])
def test_a_run_keeps_all_its_counts_whenever_the_stage_falls_silent(
    kept_s: float | None, asked: int, fails_at: int
) -> None:
    """24 patterns in three blocks, a look before the run and one after each block."""
    bench = Bench()
    counter = Slow(
        bench, [bins(0, 10), bins(10, 10), bins(20, 4)], None if kept_s is None else round(kept_s / PERIOD_S)
    )
    stage = Asked(bench.clock, fails_at=fails_at)
    devices = Devices.of({"modulator": bench.modulator, "counter": counter, "stage": stage}, clock=bench.clock)
    timing = ModulatorTiming(picture_time_us=50)
    outcome = acquire(MOVING, timing, devices, bench.host, patterns=24, patterns_per_frame=6)
    assert outcome.error is None
    assert (outcome.report.verdict, outcome.report.patterns_recorded) == ("good", 24)
    assert len(stage.asked_at_s) == (min(asked, fails_at) if fails_at else asked)
    assert outcome.stage is not None
    # One of the looks failed, where it came to that; the end of the motion is told in any case.
    assert len(outcome.stage) == len(stage.asked_at_s) - (0 < fails_at <= asked) + 1
