"""Limits of a stage refuse by their figures, and whatever is no number."""

import math

import pytest

from protocols import MotionProfile, MotionTooFast, StageLimits, TravelExceeded

LIMITS = StageLimits(travel_mm=(0.0, 400.0), max_velocity_mm_s=50.0, max_acceleration_mm_s2=200.0)


@pytest.mark.parametrize("target_mm", [0.0, 400.0])
def test_both_ends_of_the_travel_may_be_reached(target_mm: float) -> None:
    LIMITS.check_target(target_mm, "stage")


@pytest.mark.parametrize("target_mm", [-0.001, 400.001, math.nan, math.inf, -math.inf])
def test_a_target_outside_the_travel_is_refused(target_mm: float) -> None:
    with pytest.raises(TravelExceeded, match=f"stage: saw a target of {target_mm:g} mm; expected 0 to 400 mm"):
        LIMITS.check_target(target_mm, "stage")


def test_the_fastest_profile_is_taken() -> None:
    LIMITS.check_profile(MotionProfile(velocity_mm_s=50, acceleration_mm_s2=200, initial_velocity_mm_s=50), "stage")


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"velocity_mm_s": 50.1}, r"velocity of 50\.1 mm/s; expected more than 0 and at most 50 mm/s"),
        ({"acceleration_mm_s2": 201.0}, r"acceleration of 201 mm/s\^2; expected more than 0 and at most 200 mm/s\^2"),
        ({"initial_velocity_mm_s": 26.0}, "initial velocity of 26 mm/s; expected more than 0 and at most 25 mm/s"),
        ({"velocity_mm_s": math.nan}, "velocity of nan mm/s"),
    ],
)
def test_a_profile_beyond_the_limits_is_refused(changed: dict[str, float], words: str) -> None:
    profile = MotionProfile(velocity_mm_s=25, acceleration_mm_s2=50).model_copy(update=changed)
    with pytest.raises(MotionTooFast, match=words):
        LIMITS.check_profile(profile, "stage")


@pytest.mark.parametrize(
    ("velocity_mm_s", "acceleration_mm_s2", "gentle"), [(50.0, 200.0, (10.0, 50.0)), (4.0, 20.0, (4.0, 20.0))]
)
def test_a_stage_moves_gently_where_nobody_says_how(
    velocity_mm_s: float, acceleration_mm_s2: float, gentle: tuple[float, float]
) -> None:
    """At 10 mm/s and 50 mm/s^2; a stage that cannot do that, as fast as it can."""
    limits = StageLimits(
        travel_mm=(0.0, 1.0), max_velocity_mm_s=velocity_mm_s, max_acceleration_mm_s2=acceleration_mm_s2
    )
    profile = limits.gentle_profile
    assert (profile.velocity_mm_s, profile.acceleration_mm_s2, profile.initial_velocity_mm_s) == (*gentle, 0.0)
    limits.check_profile(profile, "stage")
