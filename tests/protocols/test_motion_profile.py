"""A trapezoid in velocity by hand: a ramp takes v/a and (v^2 - v0^2) / 2a; too short a move is a triangle."""

import numpy as np
import pytest

from protocols import MotionProfile

CRUISE = MotionProfile(velocity_mm_s=20, acceleration_mm_s2=100)
"""Ramps of 0.2 s and 2 mm."""

STEPPER = MotionProfile(velocity_mm_s=20, acceleration_mm_s2=100, initial_velocity_mm_s=10)
"""Starts at half its velocity: ramps of 0.1 s and 1.5 mm."""


def test_ramps_by_hand() -> None:
    assert (CRUISE.ramp_time_s, CRUISE.ramp_mm) == (0.2, 2.0)
    assert (STEPPER.ramp_time_s, STEPPER.ramp_mm) == (0.1, 1.5)


@pytest.mark.parametrize(
    ("profile", "distance_mm", "duration_s"),
    [
        (CRUISE, 10.0, 0.2 + 6 / 20 + 0.2),
        (CRUISE, -10.0, 0.7),
        (CRUISE, 4.0, 0.4),  # just reaches its velocity
        (CRUISE, 1.0, 2 * 10 / 100),  # up to sqrt(100 x 1) = 10 mm/s and down again
        (CRUISE, 0.0, 0.0),
        (STEPPER, 3.0, 0.2),
        (STEPPER, 5.0, 0.2 + 2 / 20),
        (STEPPER, 1.25, 2 * 5 / 100),  # up to sqrt(100 x 1.25 + 10^2) = 15 mm/s
    ],
)
def test_how_long_a_move_takes(profile: MotionProfile, distance_mm: float, duration_s: float) -> None:
    assert profile.duration_s(distance_mm) == pytest.approx(duration_s)


@pytest.mark.parametrize(
    ("profile", "distance_mm", "elapsed_s", "covered_mm"),
    [
        (CRUISE, 10.0, -1.0, 0.0),
        (CRUISE, 10.0, 0.1, 0.5),  # a t^2 / 2
        (CRUISE, 10.0, 0.2, 2.0),
        (CRUISE, 10.0, 0.35, 5.0),  # 2 mm and 0.15 s at 20 mm/s
        (CRUISE, 10.0, 0.6, 9.5),  # 0.1 s before the end
        (CRUISE, 10.0, 0.7, 10.0),
        (CRUISE, 10.0, 9.0, 10.0),
        (CRUISE, -10.0, 0.35, -5.0),
        (CRUISE, 1.0, 0.1, 0.5),  # the tip of the triangle
        (CRUISE, 1.0, 0.15, 0.875),
        (STEPPER, 5.0, 0.05, 0.625),  # v0 t + a t^2 / 2 = 0.5 + 0.125
        (STEPPER, 5.0, 0.15, 2.5),  # 1.5 mm and 0.05 s at 20 mm/s
        (STEPPER, 5.0, 0.25, 4.375),
        (STEPPER, 1.25, 0.05, 0.625),
        (CRUISE, 0.0, 0.1, 0.0),
    ],
)
def test_how_far_a_move_has_come(
    profile: MotionProfile, distance_mm: float, elapsed_s: float, covered_mm: float
) -> None:
    assert profile.travelled_mm(distance_mm, elapsed_s) == pytest.approx(covered_mm)


@pytest.mark.parametrize("profile", [CRUISE, STEPPER])
@pytest.mark.parametrize("distance_mm", [1.0, 3.9, 4.1, 25.0])
def test_the_way_is_the_integral_of_a_velocity_that_never_exceeds_its_limits(
    profile: MotionProfile, distance_mm: float
) -> None:
    time_s = np.linspace(0, profile.duration_s(distance_mm), 2001)
    way_mm = np.array([profile.travelled_mm(distance_mm, t) for t in time_s.tolist()])
    velocity_mm_s = np.diff(way_mm) / time_s[1]
    assert way_mm[-1] == pytest.approx(distance_mm)
    assert velocity_mm_s.max() <= 20.001
    assert velocity_mm_s.min() >= profile.initial_velocity_mm_s - 1e-6
    assert np.abs(np.diff(velocity_mm_s) / time_s[1]).max() <= 100.01
