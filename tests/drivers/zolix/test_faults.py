"""The driver against controllers that answer late, twice, partly or not at all: no hang, no crash, no wrong position."""

from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from drivers.zolix.driver import Ka400z
from drivers.zolix.motion import ZolixMotion
from protocols import (
    BenchContext,
    DeviceBusy,
    DeviceError,
    DeviceRefused,
    DeviceTimeout,
    MotionProfile,
    StagePosition,
)
from tests.drivers.zolix import scripted
from tests.drivers.zolix.faulty import Fault, FaultyController, FaultyMc600, FaultySc300
from tests.drivers.zolix.scripted import VirtualClock

PULSES_PER_MM = 400
PROFILE = MotionProfile(velocity_mm_s=20, acceleration_mm_s2=100)
FAULTS: list[Fault] = ["late", "twice", "partly", "lost"]
MAY_BE_RAISED = (DeviceTimeout, DeviceRefused, DeviceError)
LONGEST_CALL_S = 12.0
"""Twice the longest move (60 mm at 20 mm/s, plus a fifth, plus a second), with room for some answers in vain."""


class StageUnderFaults(RuleBasedStateMachine):
    """Any order of calls and faults."""

    controller_type: type[FaultyController] = FaultyMc600

    @initialize()
    def open(self) -> None:
        """Open on a healthy controller."""
        self.clock = VirtualClock()
        self.controller = self.controller_type(self.clock)
        self.stage = Ka400z(
            scripted.settings(travel_mm=(0, 60)), BenchContext(clock=self.clock, transport=self.controller)
        )
        self.motion: ZolixMotion | None = None

    @rule(faults=st.lists(st.sampled_from([*FAULTS, None]), min_size=1, max_size=4))
    def spoil(self, faults: list[Fault | None]) -> None:
        """Spoil some of the next answers."""
        self.controller.faults.extend(faults)

    @rule(target_mm=st.integers(0, 120).map(lambda half: half / 2))
    def move(self, target_mm: float) -> None:
        """Start a move, or be told why not."""
        motion = self.bounded(lambda: self.stage.move_to(target_mm, PROFILE), DeviceBusy)
        self.motion = motion if isinstance(motion, ZolixMotion) else None

    @rule(seconds=st.floats(0, 4))
    def let_time_pass(self, seconds: float) -> None:
        """Do nothing."""
        self.clock.sleep_s(seconds)

    @rule()
    def ask(self) -> None:
        """A position is where the stage was at some time between question and answer, or says that it is predicted."""
        before_s = self.clock.time_s
        here = self.bounded(self.stage.position)
        if isinstance(here, StagePosition) and not here.predicted:
            self.must_be_true(here, before_s)

    @precondition(lambda self: self.motion is not None)
    @rule(timeout_s=st.none() | st.floats(0, 3))
    def wait(self, timeout_s: float | None) -> None:
        """A wait that returns, returns at the target; the stage stands."""
        assert self.motion is not None
        motion = self.motion
        here = self.bounded(lambda: motion.wait(timeout_s))
        if isinstance(here, StagePosition):
            assert here.reported_mm == pytest.approx(motion.target_mm, abs=2 / PULSES_PER_MM)
            assert not here.predicted

    @rule()
    def stop(self) -> None:
        """Takes no time at all."""
        before_s = self.clock.time_s
        self.stage.stop()
        assert self.clock.time_s == before_s

    @rule()
    def recover(self) -> None:
        """When the line is healthy again, stop and move are enough: the stage goes where it is told."""
        self.controller.faults.clear()
        self.clock.sleep_s(10)
        self.stage.stop()
        self.motion = self.stage.move_to(30, PROFILE)
        assert self.motion.wait().reported_mm == 30
        assert self.controller.true_pulses(self.clock.time_s) == 30 * PULSES_PER_MM

    @invariant()
    def done_means_that_the_stage_stands(self) -> None:
        """The last motion is never called over while the stage moves."""
        motion = getattr(self, "motion", None)
        if isinstance(motion, ZolixMotion) and motion.standing_mm is not None:
            truth_mm = self.controller.true_pulses(self.clock.time_s) / PULSES_PER_MM
            assert motion.standing_mm == pytest.approx(truth_mm, abs=2 / PULSES_PER_MM)
            assert not self.controller.moving

    def bounded(self, call: Callable[[], object], *also: type[DeviceError]) -> object:
        """Give what ``call`` gives, or None where it raises an error that it may; in bounded time."""
        before_s = self.clock.time_s
        given: object = None
        problem: DeviceError | None = None
        try:
            given = call()
        except DeviceError as error:
            problem = error
        assert self.clock.time_s - before_s < LONGEST_CALL_S
        assert problem is None or (type(problem) in (*MAY_BE_RAISED, *also) and "To do:" in str(problem))
        return given

    def must_be_true(self, here: StagePosition, before_s: float) -> None:
        """Whether the truth went through this position since ``before_s``."""
        truth = [self.controller.true_pulses(t) / PULSES_PER_MM for t in (before_s, self.clock.time_s)]
        slack_mm = 2 / PULSES_PER_MM
        assert min(truth) - slack_mm <= here.reported_mm <= max(truth) + slack_mm


class Sc300UnderFaults(StageUnderFaults):
    """The same, mute in motion."""

    controller_type = FaultySc300


@pytest.mark.parametrize("machine", [StageUnderFaults, Sc300UnderFaults])
def test_no_order_of_calls_and_faults_hangs_crashes_or_gives_a_wrong_position(
    machine: type[StageUnderFaults],
) -> None:
    """Rule-based: calls, time and faults in any order."""
    run_state_machine_as_test(
        machine,
        settings=settings(
            max_examples=40,
            stateful_step_count=20,
            deadline=None,
            suppress_health_check=[HealthCheck.too_slow],
            derandomize=True,
        ),
    )
