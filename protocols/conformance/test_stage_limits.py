"""What a ``LinearStage`` says of itself, and what it refuses before anything moves."""

import math
from collections.abc import Callable

import pytest

from protocols.conformance.rigs import StageRig
from protocols.conformance.spot import Spot, near, stands
from protocols.conformance.stage_fixtures import *  # noqa: F403
from protocols.conformance.support import assert_speaks
from protocols.errors import MotionTooFast, PlanError, TravelExceeded
from protocols.stage import LinearStage, Motion, MotionProfile

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
    assert near(stands(rig, stage).reported_mm, spot.middle_mm, rig.tolerance_mm)
    stage.move_to(spot.middle_mm + spot.reach_mm, spot.profile).wait()


def test_checking_what_is_allowed_moves_nothing(rig: StageRig, stage: LinearStage, spot: Spot) -> None:
    low, high = spot.travel_mm
    for target_mm in (low, high, spot.middle_mm + spot.reach_mm):
        stage.check(target_mm, spot.profile)
    stage.check(
        high,
        spot.but(velocity_mm_s=spot.limits.max_velocity_mm_s, acceleration_mm_s2=spot.limits.max_acceleration_mm_s2),
    )
    assert near(stands(rig, stage).reported_mm, spot.middle_mm, rig.tolerance_mm)
