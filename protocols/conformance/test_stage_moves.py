"""Moves of a ``LinearStage``: where they lead, how long they take, and what is told on the way."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from protocols.conformance.rigs import StageRig
from protocols.conformance.spot import Spot, near, stands
from protocols.conformance.stage_fixtures import *  # noqa: F403
from protocols.conformance.support import assert_speaks
from protocols.errors import DeviceBusy, DeviceTimeout
from protocols.stage import LinearStage, Motion, StagePosition


@pytest.mark.parametrize("sign", [1, -1], ids=["up", "down"])
@pytest.mark.parametrize("share", [1.0, 0.125, 0.02])
def test_it_goes_where_it_is_told_and_reads_back(
    rig: StageRig, stage: LinearStage, spot: Spot, sign: int, share: float
) -> None:
    target_mm = spot.middle_mm + sign * share * spot.reach_mm
    motion = stage.move_to(target_mm, spot.profile)
    assert near(motion.target_mm, target_mm, rig.tolerance_mm)
    end = motion.wait()
    assert motion.done
    for position in (end, stands(rig, stage)):
        assert near(position.reported_mm, target_mm, rig.tolerance_mm)
        assert near(position.commanded_mm, target_mm, rig.tolerance_mm)
        assert not position.predicted


@pytest.mark.parametrize("sign", [1, -1], ids=["up", "down"])
def test_relative_moves_are_signed_and_add_up(rig: StageRig, stage: LinearStage, spot: Spot, sign: int) -> None:
    at_mm = spot.middle_mm
    for step_mm in (sign * spot.reach_mm, -sign * 0.25 * spot.reach_mm, -sign * 0.75 * spot.reach_mm):
        at_mm += step_mm
        motion = stage.move_by(step_mm, spot.profile)
        assert near(motion.target_mm, at_mm, rig.tolerance_mm)
        assert near(motion.wait().reported_mm, at_mm, rig.tolerance_mm)
    assert near(stands(rig, stage).reported_mm, spot.middle_mm, rig.tolerance_mm)


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


@pytest.mark.parametrize("sign", [1, -1], ids=["up", "down"])
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
