"""How a motion of a ``LinearStage`` is ended before its time: by a stop, on the way home, or by leaving."""

import pytest

from protocols.conformance.rigs import StageRig
from protocols.conformance.spot import Spot, near, stands
from protocols.conformance.stage_fixtures import *  # noqa: F403
from protocols.conformance.support import assert_speaks, error_of, in_another_thread
from protocols.errors import DeviceError, DeviceTimeout
from protocols.stage import LinearStage, Motion

# Stopping


def test_stopping_a_stage_that_stands_changes_nothing(rig: StageRig, stage: LinearStage, spot: Spot) -> None:
    stage.stop()
    stage.stop()
    motion = stage.move_by(spot.reach_mm, spot.profile)
    end = motion.wait()
    stage.stop()
    motion.stop()
    assert near(motion.wait().reported_mm, end.reported_mm, rig.tolerance_mm), "a motion that was over is over"
    assert near(stands(rig, stage).reported_mm, end.reported_mm, rig.tolerance_mm)


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
    done_mm = stands(rig, stage).reported_mm - spot.middle_mm
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
    assert stands(rig, stage).reported_mm < spot.middle_mm + spot.reach_mm - rig.tolerance_mm


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


@pytest.mark.parametrize("sign", [1, -1], ids=["up", "down"])
def test_a_stage_that_was_stopped_moves_again(rig: StageRig, stage: LinearStage, spot: Spot, sign: int) -> None:
    stopped = stage.move_by(spot.reach_mm, spot.profile)
    rig.clock.sleep_s(0.4 * spot.whole_s)
    stage.stop()
    target_mm = spot.middle_mm + sign * spot.reach_mm
    motion = stage.move_to(target_mm, spot.profile)
    stopped.stop()  # it is over, so this does not stop the new one
    assert near(motion.wait().reported_mm, target_mm, rig.tolerance_mm)
    assert near(stands(rig, stage).reported_mm, target_mm, rig.tolerance_mm)


# Homing


def test_nothing_is_homed_unless_it_is_asked_for(rig: StageRig) -> None:
    with rig.open() as stage:
        spot = Spot(stage, rig)
        homed, at_mm = stage.homed, stage.position().reported_mm
        assert near(stands(rig, stage).reported_mm, at_mm, rig.tolerance_mm), "it moves by itself"
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
    stands(rig, stage)


# Closing


def test_leaving_stops_the_stage(rig: StageRig) -> None:
    with rig.open() as stage:
        spot = Spot(stage, rig)
        stage.move_to(spot.middle_mm, spot.profile).wait()
        stage.move_by(spot.reach_mm, spot.profile)
        rig.clock.sleep_s(0.4 * spot.whole_s)
    rig.clock.sleep_s(spot.whole_s)
    with rig.open() as stage:
        done_mm = stands(rig, stage).reported_mm - spot.middle_mm
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
                assert near(stands(rig, stage).reported_mm, stands_mm, rig.tolerance_mm)
            stands_mm = stage.move_to(spot.middle_mm + spot.reach_mm, spot.profile).wait().reported_mm
    assert len(identities) == 1
