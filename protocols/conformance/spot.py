"""Where and how fast a stage moves in the tests: slowly, and near to where it stands."""

from typing import Any, Final

from protocols.stage import LinearStage, MotionProfile


def near(one_mm: float, other_mm: float, tolerance_mm: float) -> bool:
    """Whether two positions are the same."""
    return abs(one_mm - other_mm) <= tolerance_mm


class Spot:
    """A stretch of the travel round the place where the stage stands, 12 mm or a fifth of the travel long."""

    def __init__(self, stage: LinearStage) -> None:
        self.limits: Final = stage.limits
        self.travel_mm: Final = stage.limits.travel_mm
        low, high = self.travel_mm
        room_mm = min(6.0, (high - low) / 10)
        here_mm = stage.position().reported_mm
        self.middle_mm: Final = round(min(max(here_mm, low + room_mm), high - room_mm), 1)
        """Position at which each test begins, in millimetres."""

        self.reach_mm: Final = 0.9 * room_mm
        """Longest distance of a test from there, in millimetres."""

        velocity_mm_s = min(5.0, 0.5 * self.limits.max_velocity_mm_s)
        self.profile: Final = MotionProfile(
            velocity_mm_s=velocity_mm_s,
            acceleration_mm_s2=min(20.0 * velocity_mm_s / 5.0, 0.5 * self.limits.max_acceleration_mm_s2),
        )
        """A profile well inside the limits."""

        self.whole_s: Final = self.profile.duration_s(self.reach_mm)
        """Time of the move over ``reach_mm``, in seconds."""

    def but(self, **changes: Any) -> MotionProfile:
        """Give the profile with other figures."""
        return MotionProfile(**{**self.profile.model_dump(exclude_unset=True), **changes})
