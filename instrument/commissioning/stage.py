"""What can be measured of a stage. It is brought back to where it stood."""

from typing import Final

import numpy as np

from protocols import Answer, Clock, LinearStage, MotionProfile

ASKED: Final = 20
"""Positions that are asked for at rest."""

TIMES: Final = 3
"""Moves there and back."""

_LONGEST_MM: Final = 2.0
"""Length of the stretch, where the travel has room for it."""

_LOOK_S: Final = 0.02
"""Time between two looks at a stage that moves."""

_LATE_S: Final = 0.1
_LATE: Final = 0.1
"""Difference of a move from its expected length, and share of that length, that are allowed together."""


class Stretch:
    """The short stretch of the travel that is used: 2 mm or a tenth of the travel, to the side that has room."""

    def __init__(self, stage: LinearStage) -> None:
        limits = stage.limits
        low, high = limits.travel_mm
        self.here_mm: Final = stage.position().reported_mm
        """Where it begins and ends, in millimetres."""

        length_mm = min(_LONGEST_MM, (high - low) / 10)
        self.there_mm: Final = self.here_mm + (length_mm if high - self.here_mm >= self.here_mm - low else -length_mm)
        """Its other end, in millimetres."""

        velocity_mm_s = min(5.0, 0.5 * limits.max_velocity_mm_s)
        self.profile: Final = MotionProfile(
            velocity_mm_s=velocity_mm_s, acceleration_mm_s2=min(20.0, 0.5 * limits.max_acceleration_mm_s2)
        )
        """Slow and soft."""

    def __str__(self) -> str:
        """Say what will be done."""
        low, high = sorted((self.here_mm, self.there_mm))
        return f"between {low:.3f} and {high:.3f} mm at up to {self.profile.velocity_mm_s:g} mm/s, and back"


def standing(stage: LinearStage, clock: Clock) -> Answer:
    """Ask for the position again and again. Nothing moves."""
    began_s = clock.now_s()
    positions = [stage.position().reported_mm for _ in range(ASKED)]
    each_s = (clock.now_s() - began_s) / ASKED
    spread_mm = max(positions) - min(positions)
    return Answer(
        said=f"{positions[-1]:.4f} mm, origin {'known' if stage.homed else 'not known'}; an answer takes {1e3 * each_s:.3g} ms, "
        f"{ASKED} of them differ by {1e3 * spread_mm:.3g} um",
        figures={"position_mm": positions[-1], "homed": stage.homed, "answer_s": each_s, "spread_mm": spread_mm},
    )


def travel(stage: LinearStage, clock: Clock) -> Answer:
    """Move there and back, and look on."""
    stretch = Stretch(stage)
    length_mm = abs(stretch.there_mm - stretch.here_mm)
    expected_s = stretch.profile.duration_s(length_mm)
    times_s: list[float] = []
    errors_mm: list[float] = []
    ends_mm: list[float] = []
    answers_s: list[float] = []
    predicted = False
    for _ in range(TIMES):
        for target_mm in (stretch.there_mm, stretch.here_mm):
            began_s = clock.now_s()
            motion = stage.move_to(target_mm, stretch.profile)
            while not motion.done and (look_s := clock.now_s()) < stage.stands_by_s:
                predicted |= stage.position().predicted
                answers_s.append(clock.now_s() - look_s)
                clock.sleep_s(_LOOK_S)
            errors_mm.append(motion.wait().reported_mm - target_mm)
            times_s.append(clock.now_s() - began_s)
        ends_mm.append(stage.position().reported_mm)
    took_s, error_mm = float(np.median(times_s)), float(np.abs(errors_mm).max())
    late = abs(took_s - expected_s) > _LATE_S + _LATE * expected_s
    answer_s = float(np.median(answers_s)) if answers_s else 0.0
    told = "predicted, as the controller is mute" if predicted else "told by the controller"
    return Answer(
        said=f"{length_mm:g} mm there and back {TIMES} times: {took_s:.3f} s a move, {expected_s:.3f} s by its profile; "
        f"meanwhile the position is {told}, an answer takes {1e3 * answer_s:.3g} ms; it ends within {1e3 * error_mm:.3g} um of "
        f"its target",
        figures={
            "move_s": took_s,
            "expected_s": expected_s,
            "longest_error_mm": error_mm,
            "spread_at_return_mm": max(ends_mm) - min(ends_mm),
            "predicted_while_moving": predicted,
            "answer_while_moving_s": answer_s,
        },
        doubts=("a move takes another time than its profile: are velocity and acceleration in the right units?",)
        if late
        else (),
    )


def stop(stage: LinearStage, clock: Clock) -> Answer:
    """Stop in the middle of a move, and go back."""
    stretch = Stretch(stage)
    ramp_mm = stretch.profile.velocity_mm_s**2 / (2 * stretch.profile.acceleration_mm_s2)
    whole_s = stretch.profile.duration_s(stretch.there_mm - stretch.here_mm)
    stage.move_to(stretch.there_mm, stretch.profile)
    clock.sleep_s(whole_s / 2)
    began_s = clock.now_s()
    stage.stop()
    stands_mm, stands_s = _standing(stage, clock)
    covered_mm = abs(stands_mm - stretch.here_mm)
    stage.move_to(stretch.here_mm, stretch.profile).wait()
    whole_mm = abs(stretch.there_mm - stretch.here_mm)
    obeyed = covered_mm < whole_mm - 0.1 * ramp_mm
    return Answer(
        said=f"a stop in mid-move, {whole_s / 2:.3f} s after its start: it stood {stands_s - began_s:.3g} s later, after "
        f"{covered_mm:.3f} of {whole_mm:g} mm",
        figures={"stopped_after_mm": covered_mm, "of_mm": whole_mm, "stands_after_s": stands_s - began_s},
        doubts=() if obeyed else ("the stop was not obeyed: keep a hand on the switch",),
    )


def homing(stage: LinearStage, clock: Clock) -> Answer:
    """Look for the origin, and go back to where it stood, if that was known."""
    known, before_mm = stage.homed, stage.position().reported_mm
    began_s = clock.now_s()
    ended = stage.home().wait()
    took_s = clock.now_s() - began_s
    if known:
        stage.move_to(before_mm, Stretch(stage).profile).wait()
    return Answer(
        said=f"homed in {took_s:.3g} s; the position is then {ended.reported_mm:.4f} mm; it stood at {before_mm:.4f} mm before, "
        + ("and is back there" if known else "by an origin that was not known, so it stays at the origin"),
        figures={
            "homing_s": took_s,
            "position_after_mm": ended.reported_mm,
            "position_before_mm": before_mm,
            "known": known,
        },
        doubts=() if stage.homed else ("it says that it is not homed, after homing",),
    )


def _standing(stage: LinearStage, clock: Clock) -> tuple[float, float]:
    """Position and time at which two looks find it at the same place."""
    before_mm = stage.position().reported_mm
    until_s = stage.stands_by_s + 1.0
    while True:
        clock.sleep_s(_LOOK_S)
        position = stage.position()
        if (position.reported_mm == before_mm and not position.predicted) or clock.now_s() > until_s:
            return position.reported_mm, clock.now_s() - _LOOK_S
        before_mm = position.reported_mm
