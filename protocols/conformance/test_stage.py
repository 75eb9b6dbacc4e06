"""What the framework relies on in a ``LinearStage``, sentence by sentence of its docstrings."""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Final

import pytest

from protocols.conformance.consent import ask_before_moving
from protocols.conformance.rigs import RigFactory, StageRig
from protocols.conformance.spot import Spot, brought_back, near
from protocols.conformance.support import assert_speaks, error_of, in_another_thread
from protocols.errors import DeviceBusy, DeviceError, DeviceTimeout, MotionTooFast, PlanError, TravelExceeded
from protocols.stage import LinearStage, Motion, MotionProfile, StagePosition

SIGNS: Final = [pytest.param(1, id="up"), pytest.param(-1, id="down")]


@pytest.fixture
def rig(open_rig: RigFactory[StageRig], pytestconfig: pytest.Config) -> Iterator[StageRig]:
    """What the device stands on; the stage is brought back after the test."""
    with open_rig() as opened:
        ask_before_moving(opened, pytestconfig)
        with brought_back(opened) as rig:
            yield rig


@pytest.fixture
def stage(rig: StageRig) -> Iterator[LinearStage]:
    """An open device, with room on both sides."""
    with rig.open() as stage:
        spot = Spot(stage, rig)
        stage.move_to(spot.middle_mm, spot.profile).wait()
        yield stage


@pytest.fixture
def spot(rig: StageRig, stage: LinearStage) -> Spot:
    """Where and how fast the stage moves in a test."""
    return Spot(stage, rig)


def _stands(rig: StageRig, stage: LinearStage) -> StagePosition:
    """Where the stage is, seen twice at the same place."""
    first = stage.position()
    rig.clock.sleep_s(0.2)
    second = stage.position()
    assert near(second.reported_mm, first.reported_mm, rig.tolerance_mm), "it still moves"
    if rig.carriage_mm is not None:
        assert near(rig.carriage_mm(), second.reported_mm, rig.tolerance_mm), "it is not where it says"
    return second


# What it is


def test_it_satisfies_the_protocol(stage: LinearStage, spot: Spot) -> None:
    assert isinstance(stage, LinearStage)
    motion = stage.move_by(spot.reach_mm, spot.profile)
    assert isinstance(motion, Motion)
    motion.wait()


def test_it_says_who_it_is(stage: LinearStage) -> None:
    identity = stage.identity
    assert all(part.strip() for part in (identity.name, identity.vendor, identity.model, identity.driver)), identity
    assert stage.identity == identity


def test_its_limits_can_be_true(stage: LinearStage) -> None:
    low, high = stage.limits.travel_mm
    assert math.isfinite(low)
    assert low < high
    assert low <= stage.position().reported_mm <= high


def test_entering_gives_the_device_itself(rig: StageRig) -> None:
    stage = rig.open()
    with stage as entered:
        assert entered is stage


def test_a_stage_that_stands_tells_where_and_when(rig: StageRig, stage: LinearStage, spot: Spot) -> None:
    before_s = rig.clock.now_s()
    position = stage.position()
    assert before_s <= position.time_s <= rig.clock.now_s()
    assert not position.predicted, "a stage that stands can be asked"
    assert near(position.reported_mm, spot.middle_mm, rig.tolerance_mm)
    assert near(position.commanded_mm, spot.middle_mm, rig.tolerance_mm)


# Limits


def _below(spot: Spot) -> tuple[float, MotionProfile]:
    return spot.travel_mm[0] - 1.0, spot.profile


def _above(spot: Spot) -> tuple[float, MotionProfile]:
    return spot.travel_mm[1] + 1.0, spot.profile


def _nowhere(spot: Spot) -> tuple[float, MotionProfile]:
    return math.nan, spot.profile


def _endless(spot: Spot) -> tuple[float, MotionProfile]:
    return math.inf, spot.profile


def _too_fast(spot: Spot) -> tuple[float, MotionProfile]:
    return spot.middle_mm, spot.but(velocity_mm_s=1.01 * spot.limits.max_velocity_mm_s)


def _too_steep(spot: Spot) -> tuple[float, MotionProfile]:
    return spot.middle_mm + spot.reach_mm, spot.but(acceleration_mm_s2=1.01 * spot.limits.max_acceleration_mm_s2)


def _too_fast_a_start(spot: Spot) -> tuple[float, MotionProfile]:
    return spot.middle_mm + spot.reach_mm, spot.but(initial_velocity_mm_s=1.01 * spot.profile.velocity_mm_s)


@pytest.mark.parametrize(
    ("asked", "error"),
    [
        (_below, TravelExceeded),
        (_above, TravelExceeded),
        (_nowhere, TravelExceeded),
        (_endless, TravelExceeded),
        (_too_fast, MotionTooFast),
        (_too_steep, MotionTooFast),
        (_too_fast_a_start, MotionTooFast),
    ],
)
def test_what_is_outside_the_limits_is_refused_before_anything_moves(
    rig: StageRig,
    stage: LinearStage,
    spot: Spot,
    asked: Callable[[Spot], tuple[float, MotionProfile]],
    error: type[PlanError],
) -> None:
    target_mm, profile = asked(spot)
    for call in (
        lambda: stage.check(target_mm, profile),
        lambda: stage.move_to(target_mm, profile),
        lambda: stage.move_by(target_mm - spot.middle_mm, profile),
    ):
        with pytest.raises(error) as refused:
            call()
        assert_speaks(refused.value, stage.identity.name)
    assert near(_stands(rig, stage).reported_mm, spot.middle_mm, rig.tolerance_mm)
    stage.move_to(spot.middle_mm + spot.reach_mm, spot.profile).wait()


def test_checking_what_is_allowed_moves_nothing(rig: StageRig, stage: LinearStage, spot: Spot) -> None:
    low, high = spot.travel_mm
    for target_mm in (low, high, spot.middle_mm + spot.reach_mm):
        stage.check(target_mm, spot.profile)
    stage.check(
        high,
        spot.but(velocity_mm_s=spot.limits.max_velocity_mm_s, acceleration_mm_s2=spot.limits.max_acceleration_mm_s2),
    )
    assert near(_stands(rig, stage).reported_mm, spot.middle_mm, rig.tolerance_mm)


# Moving


@pytest.mark.parametrize("sign", SIGNS)
@pytest.mark.parametrize("share", [1.0, 0.125, 0.02])
def test_it_goes_where_it_is_told_and_reads_back(
    rig: StageRig, stage: LinearStage, spot: Spot, sign: int, share: float
) -> None:
    target_mm = spot.middle_mm + sign * share * spot.reach_mm
    motion = stage.move_to(target_mm, spot.profile)
    assert near(motion.target_mm, target_mm, rig.tolerance_mm)
    end = motion.wait()
    assert motion.done
    for position in (end, _stands(rig, stage)):
        assert near(position.reported_mm, target_mm, rig.tolerance_mm)
        assert near(position.commanded_mm, target_mm, rig.tolerance_mm)
        assert not position.predicted


@pytest.mark.parametrize("sign", SIGNS)
def test_relative_moves_are_signed_and_add_up(rig: StageRig, stage: LinearStage, spot: Spot, sign: int) -> None:
    at_mm = spot.middle_mm
    for step_mm in (sign * spot.reach_mm, -sign * 0.25 * spot.reach_mm, -sign * 0.75 * spot.reach_mm):
        at_mm += step_mm
        motion = stage.move_by(step_mm, spot.profile)
        assert near(motion.target_mm, at_mm, rig.tolerance_mm)
        assert near(motion.wait().reported_mm, at_mm, rig.tolerance_mm)
    assert near(_stands(rig, stage).reported_mm, spot.middle_mm, rig.tolerance_mm)


def test_a_move_of_no_length_is_over_soon(rig: StageRig, stage: LinearStage, spot: Spot) -> None:
    here_mm, before_s = stage.position().reported_mm, rig.clock.now_s()
    for motion in (stage.move_to(here_mm, spot.profile), stage.move_by(0.0, spot.profile)):
        assert near(motion.wait().reported_mm, here_mm, rig.tolerance_mm)
        assert motion.done
    assert rig.clock.now_s() - before_s < 2.0
    stage.move_by(spot.reach_mm, spot.profile).wait()


@pytest.mark.parametrize("share", [1.0, 0.1], ids=["trapezoid", "triangle"])
def test_a_move_takes_the_time_of_its_profile(rig: StageRig, stage: LinearStage, spot: Spot, share: float) -> None:
    before_s = rig.clock.now_s()
    stage.move_by(share * spot.reach_mm, spot.profile).wait()
    took_s, expected_s = rig.clock.now_s() - before_s, spot.profile.duration_s(share * spot.reach_mm)
    assert 0.95 * expected_s <= took_s <= 1.2 * expected_s + 1.0


def test_a_slower_profile_is_obeyed(rig: StageRig, stage: LinearStage, spot: Spot) -> None:
    for factor in (0.5, 1.0):
        profile = spot.but(velocity_mm_s=factor * spot.profile.velocity_mm_s)
        before_s = rig.clock.now_s()
        stage.move_by(factor * spot.reach_mm, profile).wait()
        took_s, expected_s = rig.clock.now_s() - before_s, profile.duration_s(factor * spot.reach_mm)
        assert 0.95 * expected_s <= took_s <= 1.2 * expected_s + 1.0


def test_a_move_returns_at_once_and_is_done_when_the_stage_stands(
    rig: StageRig, stage: LinearStage, spot: Spot
) -> None:
    before_s = rig.clock.now_s()
    motion = stage.move_by(spot.reach_mm, spot.profile)
    assert rig.clock.now_s() - before_s < 0.5 * spot.whole_s
    assert not motion.done
    end = motion.wait()
    assert bool(motion.done)
    assert motion.wait().reported_mm == pytest.approx(end.reported_mm, abs=rig.tolerance_mm), "a second wait"


@pytest.mark.parametrize("sign", SIGNS)
def test_the_position_in_motion_lies_between_start_and_target(
    rig: StageRig, stage: LinearStage, spot: Spot, sign: int
) -> None:
    motion = stage.move_to(spot.middle_mm + sign * spot.reach_mm, spot.profile)
    seen: list[StagePosition] = []
    for _ in range(7):
        rig.clock.sleep_s(spot.whole_s / 10)
        position = stage.position()
        seen.append(position)
        assert near(position.commanded_mm, motion.target_mm, rig.tolerance_mm)
        if rig.carriage_mm is not None and not position.predicted:
            # Where in the exchange the controller looked is not known: half of it lies after time_s, half before.
            since_mm = 2 * spot.profile.velocity_mm_s * (rig.clock.now_s() - position.time_s)
            assert near(rig.carriage_mm(), position.reported_mm, since_mm + rig.tolerance_mm), "it is elsewhere"
    motion.wait()
    done_mm = [sign * (position.reported_mm - spot.middle_mm) for position in seen]
    assert done_mm[0] > 0, "it does not move, or to the wrong side"
    assert all(b >= a - rig.tolerance_mm for a, b in pairwise(done_mm)), done_mm
    assert done_mm[-1] <= spot.reach_mm + rig.tolerance_mm
    assert done_mm[-1] > 0.3 * spot.reach_mm
    times_s = [position.time_s for position in seen]
    assert all(b > a for a, b in pairwise(times_s))
    assert not stage.position().predicted, "a stage that stands can be asked"


def test_a_second_move_is_refused_and_the_first_goes_on(rig: StageRig, stage: LinearStage, spot: Spot) -> None:
    motion = stage.move_by(spot.reach_mm, spot.profile)
    calls: tuple[Callable[[], Motion], ...] = (
        lambda: stage.move_to(spot.middle_mm, spot.profile),
        lambda: stage.move_by(-spot.reach_mm, spot.profile),
        stage.home,
    )
    for call in calls:
        with pytest.raises(DeviceBusy) as refused:
            call()
        assert_speaks(refused.value, stage.identity.name)
    assert not motion.done
    assert near(motion.wait().reported_mm, spot.middle_mm + spot.reach_mm, rig.tolerance_mm)


def test_a_wait_that_is_too_short_says_how_far_the_stage_has_come_and_it_goes_on(
    rig: StageRig, stage: LinearStage, spot: Spot
) -> None:
    slow = spot.but(velocity_mm_s=spot.profile.velocity_mm_s / 5)  # to find a mute controller out takes time too
    whole_s = slow.duration_s(spot.reach_mm)
    motion = stage.move_by(spot.reach_mm, slow)
    told: list[str] = []
    for _ in range(2):
        before_s = rig.clock.now_s()
        with pytest.raises(DeviceTimeout) as late:
            motion.wait(0.25 * whole_s)
        assert rig.clock.now_s() - before_s >= 0.24 * whole_s
        assert_speaks(late.value, stage.identity.name)
        told.append(late.value.saw.rpartition(" after ")[0])
    assert told[0] != told[1], "both say the same, though the stage has come further"
    assert near(motion.wait().reported_mm, spot.middle_mm + spot.reach_mm, rig.tolerance_mm)


# Stopping


def test_stopping_a_stage_that_stands_changes_nothing(rig: StageRig, stage: LinearStage, spot: Spot) -> None:
    stage.stop()
    stage.stop()
    motion = stage.move_by(spot.reach_mm, spot.profile)
    end = motion.wait()
    stage.stop()
    motion.stop()
    assert near(motion.wait().reported_mm, end.reported_mm, rig.tolerance_mm), "a motion that was over is over"
    assert near(_stands(rig, stage).reported_mm, end.reported_mm, rig.tolerance_mm)


@pytest.mark.parametrize("by", ["stage", "motion"])
def test_a_stop_from_another_thread_stops_the_stage_before_its_target(
    rig: StageRig, stage: LinearStage, spot: Spot, by: str
) -> None:
    motion = stage.move_by(spot.reach_mm, spot.profile)
    rig.clock.sleep_s(0.4 * spot.whole_s)
    before_s = rig.clock.now_s()
    stop = stage.stop if by == "stage" else motion.stop
    in_another_thread(stop)
    stop()
    assert rig.clock.now_s() - before_s < 0.25 * spot.whole_s, "the stop waited"
    with pytest.raises(DeviceError) as stopped:
        motion.wait()
    assert not isinstance(stopped.value, DeviceTimeout)
    assert_speaks(stopped.value, stage.identity.name)
    assert motion.done
    done_mm = _stands(rig, stage).reported_mm - spot.middle_mm
    assert 0 < done_mm < spot.reach_mm - rig.tolerance_mm


def test_a_stop_reaches_the_stage_while_another_thread_waits(
    rig: StageRig, stage: LinearStage, spot: Spot, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = stage.move_by(spot.reach_mm, spot.profile)
    rig.clock.sleep_s(0.4 * spot.whole_s)
    sleep_s, slept = rig.clock.sleep_s, list[float]()

    def sleep_and_stop(duration_s: float) -> None:
        slept.append(duration_s)
        if len(slept) == 1:
            in_another_thread(stage.stop)
        sleep_s(duration_s)

    monkeypatch.setattr(rig.clock, "sleep_s", sleep_and_stop)
    assert not isinstance(error_of(motion.wait), DeviceTimeout)
    if not slept:
        pytest.skip("this driver does not wait by clock.sleep_s")
    assert _stands(rig, stage).reported_mm < spot.middle_mm + spot.reach_mm - rig.tolerance_mm


def test_it_tells_by_when_it_stands_even_if_no_stop_is_obeyed(rig: StageRig, stage: LinearStage, spot: Spot) -> None:
    """What a person at the bench is told where the stage cannot be asked: never too early, nor so late that it says nothing."""
    before_s = rig.clock.now_s()
    motion = stage.move_by(spot.reach_mm, spot.profile)
    whole_s, by_s = spot.profile.duration_s(spot.reach_mm), stage.stands_by_s
    assert before_s + whole_s <= by_s <= rig.clock.now_s() + 2 * whole_s + 5.0
    rig.clock.sleep_s(by_s - rig.clock.now_s())
    assert motion.done, "it still moves"
    stopped = stage.move_by(-spot.reach_mm, spot.profile)
    begun_s = rig.clock.now_s()
    stage.stop()
    assert stage.stands_by_s >= begun_s + 0.5 * whole_s, "a stop that was sent is not a stop that was obeyed"
    error_of(stopped.wait)


@pytest.mark.parametrize("sign", SIGNS)
def test_a_stage_that_was_stopped_moves_again(rig: StageRig, stage: LinearStage, spot: Spot, sign: int) -> None:
    stopped = stage.move_by(spot.reach_mm, spot.profile)
    rig.clock.sleep_s(0.4 * spot.whole_s)
    stage.stop()
    target_mm = spot.middle_mm + sign * spot.reach_mm
    motion = stage.move_to(target_mm, spot.profile)
    stopped.stop()  # it is over, so this does not stop the new one
    assert near(motion.wait().reported_mm, target_mm, rig.tolerance_mm)
    assert near(_stands(rig, stage).reported_mm, target_mm, rig.tolerance_mm)


# Homing


def test_nothing_is_homed_unless_it_is_asked_for(rig: StageRig) -> None:
    with rig.open() as stage:
        spot = Spot(stage, rig)
        homed, at_mm = stage.homed, stage.position().reported_mm
        assert near(_stands(rig, stage).reported_mm, at_mm, rig.tolerance_mm), "it moves by itself"
        stage.move_to(spot.middle_mm, spot.profile).wait()
        assert stage.homed == homed


def test_homing_makes_the_origin_known(rig: StageRig, stage: LinearStage, spot: Spot) -> None:
    if not rig.may_home:
        pytest.skip("the rig says that the stage may not be homed now")
    motion = stage.home()
    assert isinstance(motion, Motion)
    end = motion.wait()
    assert stage.homed
    assert near(end.reported_mm, motion.target_mm, rig.tolerance_mm)
    stage.move_to(Spot(stage, rig).middle_mm, spot.profile).wait()
    assert stage.homed


def test_homing_can_be_stopped_and_then_the_origin_is_not_known_by_it(
    rig: StageRig, stage: LinearStage, spot: Spot
) -> None:
    if not rig.may_home:
        pytest.skip("the rig says that the stage may not be homed now")
    stage.move_by(spot.reach_mm, spot.profile).wait()  # so that it is not at the origin by chance
    known = stage.homed
    motion = stage.home()
    rig.clock.sleep_s(0.1)
    stage.stop()
    with pytest.raises(DeviceError) as stopped:
        motion.wait()
    assert not isinstance(stopped.value, DeviceTimeout)
    assert known or not stage.homed
    _stands(rig, stage)


# Closing


def test_leaving_stops_the_stage(rig: StageRig) -> None:
    with rig.open() as stage:
        spot = Spot(stage, rig)
        stage.move_to(spot.middle_mm, spot.profile).wait()
        stage.move_by(spot.reach_mm, spot.profile)
        rig.clock.sleep_s(0.4 * spot.whole_s)
    rig.clock.sleep_s(spot.whole_s)
    with rig.open() as stage:
        done_mm = _stands(rig, stage).reported_mm - spot.middle_mm
        assert 0 < done_mm < spot.reach_mm - rig.tolerance_mm
        stage.move_to(spot.middle_mm, spot.profile).wait()


def test_leaving_hides_no_error(rig: StageRig) -> None:
    def fail_in_motion() -> None:
        with rig.open() as stage:
            stage.move_to(Spot(stage, rig).middle_mm, Spot(stage, rig).profile)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_in_motion()


def test_it_can_be_opened_again_after_it_was_closed(rig: StageRig) -> None:
    identities, stands_mm = set[str](), None
    for _ in range(3):
        with rig.open() as stage:
            identities.add(stage.identity.model_dump_json())
            spot = Spot(stage, rig)
            if stands_mm is not None:
                assert near(_stands(rig, stage).reported_mm, stands_mm, rig.tolerance_mm)
            stands_mm = stage.move_to(spot.middle_mm + spot.reach_mm, spot.profile).wait().reported_mm
    assert len(identities) == 1
