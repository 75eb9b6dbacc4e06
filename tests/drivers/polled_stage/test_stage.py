"""The stage on an axis of which a test says what it answers."""

from collections.abc import Callable

import pytest

from drivers.polled_stage import PolledStage, Status
from protocols import (
    DeviceBusy,
    DeviceError,
    DeviceIdentity,
    DeviceTimeout,
    MotionProfile,
    StageLimits,
    WrongState,
)
from tests.drivers.serial_line.scripted import Clock

PROFILE = MotionProfile(velocity_mm_s=2.0, acceleration_mm_s2=4.0)
"""10 mm take 10 / 2 + 2 / 4 = 5.5 s."""


class Axis:
    """Answers what ``says`` gives, and keeps what it was told."""

    tolerance_mm = 0.01

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.stops = 0
        self.told: list[object] = []
        self.mm: float | None = 0.0
        self.moving = False
        self.homed = True
        self.trouble = ""
        self.fails: DeviceError | None = None
        self.meanwhile: Callable[[], None] | None = None

    def status(self) -> Status:
        if self.fails is not None:
            raise self.fails
        return Status(self.clock.now_s(), self.mm, moving=self.moving, homed=self.homed, trouble=self.trouble)

    def check(self, profile: MotionProfile) -> None: ...

    def runs(self, profile: MotionProfile) -> MotionProfile:
        return profile

    def begin_move(self, target_mm: float, profile: MotionProfile, *, stops: int) -> None:
        self.told.append((target_mm, stops))
        self.moving = True
        if self.fails is not None:
            raise self.fails

    def begin_home(self, profile: MotionProfile, *, stops: int) -> None:
        self.told.append(("home", stops))
        self.moving = True

    def send_stop(self) -> None:
        self.stops += 1
        self.told.append("stop")

    def close(self) -> None:
        self.told.append("close")


def stage_on(**options: bool) -> tuple[PolledStage, Axis, Clock]:
    clock = Clock()
    axis = Axis(clock)
    limits = StageLimits(travel_mm=(0.0, 100.0), max_velocity_mm_s=10.0, max_acceleration_mm_s2=50.0)
    identity = DeviceIdentity(name="stage", vendor="Nobody", model="one axis")
    home = MotionProfile(velocity_mm_s=5.0, acceleration_mm_s2=50.0)
    stage = PolledStage(
        axis, clock, identity=identity, limits=limits, home_mm=1.0, home_profile=home, poll_s=0.01, **options
    )
    return stage, axis, clock


def silence() -> DeviceTimeout:
    return DeviceTimeout("stage", awaited="an answer", waited_s=0.5, progress="not a byte", remedy="look")


def test_a_motion_that_does_not_end_is_late_after_its_profile_a_fifth_and_a_second() -> None:
    stage, axis, clock = stage_on()
    clock.sleep_s(3.0)
    motion = stage.move_to(10.0, PROFILE)
    assert stage.stands_by_s == pytest.approx(3.0 + 1.2 * 5.5 + 1.0)
    axis.mm = 4.0
    with pytest.raises(DeviceTimeout, match=r"4\.000 of 10\.000 mm done \(reported\) after 7\.6") as late:
        motion.wait()
    assert clock.now_s() == pytest.approx(3.0 + 7.6, abs=0.02)
    assert not isinstance(late.value, DeviceBusy)
    with pytest.raises(DeviceBusy, match="a motion to 10 mm under way"):
        stage.move_to(5.0, PROFILE)


def test_a_motion_is_over_at_its_target_at_once_and_elsewhere_when_told_twice() -> None:
    stage, axis, clock = stage_on()
    motion = stage.move_to(10.0, PROFILE)
    axis.mm, axis.moving = 10.009, False
    assert motion.done
    assert clock.now_s() == 0.0
    assert motion.wait().reported_mm == 10.009
    elsewhere = stage.move_to(20.0, PROFILE)
    axis.mm, axis.moving, axis.trouble = 15.0, False, "a switch"

    def creep() -> None:
        axis.mm = 15.02

    clock.meanwhile = creep
    assert [elsewhere.done, elsewhere.done] == [False, True], "it was told at two places, and then at one"
    with pytest.raises(DeviceError, match=r"over at 15\.02 mm; the controller says: a switch"):
        elsewhere.wait()


def test_a_stopped_motion_has_the_time_to_slow_down_a_fifth_and_a_second() -> None:
    """1.2 x 2 / 4 + 1 = 1.6 s from the stop on."""
    stage, axis, clock = stage_on()
    motion = stage.move_to(10.0, PROFILE)
    clock.sleep_s(0.5)
    motion.stop()
    assert axis.told[-1] == "stop"
    with pytest.raises(DeviceTimeout, match="the stopped motion to 10 mm"):
        motion.wait()
    assert clock.now_s() == pytest.approx(0.5 + 1.6, abs=0.02)
    axis.moving, axis.mm = False, 2.0
    with pytest.raises(DeviceError, match="over at 2 mm, after a stop"):
        motion.wait()
    assert stage.move_to(5.0, PROFILE).target_mm == 5.0
    motion.stop()
    assert axis.told[-1] != "stop", "a motion that is over stops nothing"


def test_what_another_program_moves_is_waited_for_as_long_as_a_stop_takes() -> None:
    """1.2 x 10 / 50 + 1 = 1.24 s."""
    stage, axis, clock = stage_on()
    axis.moving = True
    with pytest.raises(DeviceBusy, match="another program"):
        stage.move_to(5.0, PROFILE)
    assert clock.now_s() == pytest.approx(1.24, abs=0.02)
    assert axis.told == []
    clock.meanwhile = lambda: setattr(axis, "moving", False)
    stage.move_to(5.0, PROFILE)
    assert axis.told == [(5.0, 0)]


def test_a_mute_motion_is_predicted_and_after_a_stop_held() -> None:
    """After 1.5 s at 2 mm/s and 4 mm/s^2: 2 x (1.5 - 0.25) = 2.5 mm."""
    stage, axis, clock = stage_on()
    motion = stage.move_to(10.0, PROFILE)
    axis.mm = None
    clock.sleep_s(1.5)
    position = stage.position()
    assert (position.predicted, position.commanded_mm) == (True, 10.0)
    assert position.reported_mm == pytest.approx(2.5)
    stage.stop()
    clock.sleep_s(1.0)
    assert stage.position().reported_mm == pytest.approx(2.5)
    with pytest.raises(DeviceTimeout, match=r"2\.500 of 10\.000 mm done \(predicted: no answer\)"):
        motion.wait(0.1)


def test_a_controller_that_tells_no_place_before_any_motion_is_in_the_wrong_state() -> None:
    stage, axis, _ = stage_on()
    axis.mm = None
    with pytest.raises(WrongState):
        stage.position()


def test_a_lost_answer_ends_no_motion() -> None:
    stage, axis, _ = stage_on()
    motion = stage.move_to(10.0, PROFILE)
    axis.fails = silence()
    assert not motion.done
    with pytest.raises(DeviceTimeout, match="predicted: no answer"):
        motion.wait(0.1)
    axis.fails, axis.mm, axis.moving = None, 10.0, False
    assert motion.done


def test_a_move_without_answer_is_stopped_and_stays_under_way() -> None:
    stage, axis, _ = stage_on()
    begin = axis.begin_move

    def mute(target_mm: float, profile: MotionProfile, *, stops: int) -> None:
        begin(target_mm, profile, stops=stops)
        raise silence()

    axis.begin_move = mute  # type: ignore[method-assign]
    with pytest.raises(DeviceTimeout):
        stage.move_to(10.0, PROFILE)
    assert axis.told == [(10.0, 0), "stop"]
    assert stage.stands_by_s == pytest.approx(2.0 + 7.6), "begun 2 s later at the latest"


def test_relative_moves_begin_where_it_stands_and_carry_the_count_of_stops() -> None:
    stage, axis, _ = stage_on()
    stage.stop()
    axis.mm = 30.0
    assert stage.move_by(-2.5, PROFILE).target_mm == 27.5
    assert axis.told == ["stop", (27.5, 1)]


def test_homing_may_take_the_whole_travel() -> None:
    """100 mm at 5 mm/s and 50 mm/s^2 take 20.1 s."""
    stage, axis, _ = stage_on()
    motion = stage.home()
    assert motion.target_mm == 1.0
    assert axis.told == [("home", 0)]
    assert stage.stands_by_s == pytest.approx(1.2 * 20.1 + 1.0)


def test_a_stage_that_must_be_homed_moves_only_then() -> None:
    stage, axis, _ = stage_on(require_home=True)
    axis.homed = False
    with pytest.raises(WrongState):
        stage.move_to(5.0, PROFILE)
    axis.homed = True
    stage.move_to(5.0, PROFILE)
    assert stage.homed


def test_leaving_stops_and_closes_once() -> None:
    stage, axis, _ = stage_on()
    with stage as same:
        assert same is stage
    stage.__exit__(None, None, None)
    assert axis.told == ["stop", "close"]
