"""Where and how fast a stage moves in the tests: slowly, near to where it stood, and back there afterwards."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, Final

from protocols.clock import MonotonicClock
from protocols.conformance.rigs import StageRig
from protocols.stage import LinearStage, MotionProfile, StagePosition

REACH_MM: Final = 6.0
"""Room that the tests want on both sides, where the travel is ten times as long."""


def near(one_mm: float, other_mm: float, tolerance_mm: float) -> bool:
    """Whether two positions are the same."""
    return abs(one_mm - other_mm) <= tolerance_mm


class Spot:
    """A stretch of the travel round the place where the stage stood before the test, 12 mm or a fifth of the travel long."""

    def __init__(self, stage: LinearStage, rig: StageRig) -> None:
        self.limits: Final = stage.limits
        self.travel_mm: Final = stage.limits.travel_mm
        low, high = self.travel_mm
        room_mm = min(REACH_MM, (high - low) / 10)
        if rig.span_mm is not None:
            low, high = max(low, rig.span_mm[0]), min(high, rig.span_mm[1])
            room_mm = min(room_mm, (high - low) / 2)
        here_mm = stage.position().reported_mm if rig.begun_mm is None else rig.begun_mm
        self.middle_mm: Final = min(max(round(here_mm, 1), low + room_mm), high - room_mm)
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


def is_hardware(rig: StageRig, stage: LinearStage) -> bool:
    """Whether something real moves: the time is the host's own, and the stage does not say that it is simulated."""
    return isinstance(rig.clock, MonotonicClock) and not stage.identity.simulated


def will_do(rig: StageRig, stage: LinearStage) -> str:
    """Say what the tests do with this stage, for a person to agree to.

    Raises:
        AssertionError: the stage stands outside the span of the rig.
    """
    here_mm, spot = stage.position().reported_mm, Spot(stage, rig)
    if rig.span_mm is not None:
        low, high = rig.span_mm
        assert low <= here_mm <= high, (
            f"the stage stands at {here_mm:g} mm, and the rig's span_mm is {low:g} to {high:g} mm. To do: move it there, or"
            " correct the rig"
        )
    low_mm, high_mm = min(here_mm, spot.middle_mm - spot.reach_mm), max(here_mm, spot.middle_mm + spot.reach_mm)
    home = ", and to its origin (may_home)" if rig.may_home else ""
    return (
        f"{stage.identity.vendor} {stage.identity.model} stands at {here_mm:g} mm. It will be moved between {low_mm:g} and"
        f" {high_mm:g} mm, at {spot.profile.velocity_mm_s:g} mm/s{home}, and back after each test."
    )


def stands(rig: StageRig, stage: LinearStage) -> StagePosition:
    """Where the stage is, seen twice at the same place."""
    first = stage.position()
    rig.clock.sleep_s(0.2)
    second = stage.position()
    assert near(second.reported_mm, first.reported_mm, rig.tolerance_mm), "it still moves"
    if rig.carriage_mm is not None:
        assert near(rig.carriage_mm(), second.reported_mm, rig.tolerance_mm), "it is not where it says"
    return second


@contextmanager
def brought_back(rig: StageRig) -> Generator[StageRig]:
    """Give the rig with the place where its stage stands, and bring the stage back there, whatever happened in between."""
    with rig.open() as stage:
        begun_mm = stage.position().reported_mm
    try:
        yield replace(rig, begun_mm=begun_mm)
    finally:
        with rig.open() as stage:
            spot = Spot(stage, replace(rig, begun_mm=begun_mm))
            low, high = spot.travel_mm
            back_mm = min(max(begun_mm, low), high)
            if not near(stage.position().reported_mm, back_mm, rig.tolerance_mm):
                stage.move_to(back_mm, spot.profile).wait()
