"""What the stage did, held against what it was told to do, by its own word and by the image."""

from typing import Final

import numpy as np

from instrument.config import ORIENTATIONS, Orientation, upright_angle_deg
from instrument.plan import MotionPlan
from instrument.recording import Recording
from instrument.tracking import Quantity, Trajectory
from protocols import Floats, Frozen

_SURE: Final = 2.0  # half-widths of the 95 % interval beyond which a ratio is not 1
_LEAST: Final = 0.01  # relative difference of travels that is told
_SETTLED_MM: Final = 0.02  # from its target at which a stage has arrived
_MOVED_MM: Final = 0.5  # travel of a stage that every bench sees
_RESTS_PX: Final = 1.0  # displacement below which what is seen stands still
_MOVING: Final = 0.1  # of the velocity, above which a position tells a lag
_AWAY_DEG: Final = 20.0  # from the calibrated axis at which the picture may lie otherwise
_FEWEST_PX: Final = 4.0  # of travel below which a direction says nothing


class StageFigures(Frozen):
    """The stage's run."""

    commanded_mm: float
    """Travel that was commanded, with its sign: from the middle of the frame that displacements are relative to, to the middle of
    the last frame, or, where the object is not seen until the end, of the one at which ``MotionFit.travel`` ends."""

    travel_ratio: Quantity | None
    """Travel of the image, in mm by the calibration, over the one commanded; None without a calibration."""

    lag_s: float | None
    """By how much the positions told during the run are behind the profile; None where the controller was mute."""

    end_error_mm: float | None
    """Position told after the run minus the one that was commanded; None where none was told."""

    away_deg: float | None = None
    """Direction in which the image moved, against that of the calibration, clockwise as one looks at the picture, -180 to 180;
    None without a calibration, or with too little travel."""

    lies: tuple[Orientation, ...] = ()
    """How the picture may lie against that of the calibration, so that the image would move as it did; none where it lies alike,
    or no way explains the direction."""

    at_rest_within_px: float | None = None
    """How far at most what is seen moved, by its interval, where that is nothing though the stage was sent; else None."""

    def sentences(self) -> tuple[str, ...]:
        """Say what is not as it should be."""
        found: list[str] = []
        ratio = self.travel_ratio
        if self.at_rest_within_px is not None:
            found.append(
                f"the stage was sent over {abs(self.commanded_mm):.3g} mm, and what is seen stands still, within "
                f"{self.at_rest_within_px:.2g} px: a background without the object, an object that is far from the field or "
                "does not ride on the stage, or a stage that did not move; look at the object and at where the stage starts"
            )
        elif self.away_deg is not None and abs(self.away_deg) > _AWAY_DEG:
            sense = "clockwise" if self.away_deg > 0 else "counter-clockwise"
            turned = f"the image moved {abs(self.away_deg):.0f} degrees {sense}"
            found.append(
                f"{turned} from the stage's calibrated axis: "
                + (self._lies_otherwise() or "look at the stage's mounting")
                + "; mend the optics or the modulator's flips, or calibrate again"
            )
        elif ratio is not None:
            half = (ratio.high - ratio.low) / 2
            if abs(ratio.value - 1) > max(_SURE * half, _LEAST):
                found.append(
                    f"the image moved {ratio.value:.3g} times as far as the stage was sent: px/mm is {ratio.value:.3g} times the "
                    "calibration (other optics?), or the stage missed steps: calibrate again"
                )
        if self.end_error_mm is not None and abs(self.end_error_mm) > _SETTLED_MM:
            found.append(
                f"the stage tells a position {self.end_error_mm:+.3f} mm from where it was sent: look for a limit switch, "
                "missed steps, or a stop"
            )
        return tuple(found)

    def _lies_otherwise(self) -> str:
        """Say how the picture may lie, and that the stage may have gone the other way."""
        if not self.lies:
            return ""
        back = ", or the stage goes the other way" if "turned 180" in self.lies else ""
        return f"the picture is {', or '.join(self.lies)}, against that of the calibration{back}"

    def row(self) -> str:
        """Give the figures as a person reads them."""
        parts = [f"{self.commanded_mm:.4g} mm commanded"]
        if self.travel_ratio is not None:
            half = (self.travel_ratio.high - self.travel_ratio.low) / 2
            parts.append(f"the image moved {self.travel_ratio.value:.4f} +- {half:.4f} of it")
        if self.lag_s is not None:
            parts.append(f"{round(1e3 * self.lag_s)} ms behind")
        if self.end_error_mm is not None:
            parts.append(f"settled {1e3 * self.end_error_mm:+.0f} um from its target")
        return ", ".join(parts)


def stage_figures(recording: Recording, trajectory: Trajectory) -> StageFigures | None:
    """Hold a run against its profile.

    Args:
        recording: of the run.
        trajectory: its path.

    Returns:
        The figures; None where the plan moves nothing.
    """
    motion = recording.plan.motion
    if motion is None or len(trajectory) < 2:
        return None
    run_s, middle_s = recording.plan.run_time_s, trajectory.time_s
    begun_s, ended_s = float(middle_s[trajectory.reference_frame]), float(middle_s[_travels_until(trajectory)])
    commanded_mm = motion.position_mm(run_s, ended_s) - motion.position_mm(run_s, begun_s)
    fit = trajectory.motion_mm
    ratio = None
    if fit is not None and commanded_mm:
        low, high = sorted((fit.travel.low / commanded_mm, fit.travel.high / commanded_mm))
        ratio = Quantity(
            value=fit.travel.value / commanded_mm, sigma=fit.travel.sigma / abs(commanded_mm), low=low, high=high
        )
    away_deg, lies = _direction(trajectory, commanded_mm)
    return StageFigures(
        commanded_mm=commanded_mm,
        travel_ratio=ratio,
        lag_s=_lag_s(recording, motion),
        end_error_mm=_end_error_mm(recording, motion),
        away_deg=away_deg,
        lies=lies,
        at_rest_within_px=_at_rest_within_px(trajectory, commanded_mm),
    )


def _direction(trajectory: Trajectory, commanded_mm: float) -> tuple[float | None, tuple[Orientation, ...]]:
    """Hold the direction of the image's motion against the calibrated axis, and find how the picture may lie."""
    scale = trajectory.scale
    if scale is None:
        return None, ()
    expected_px = commanded_mm * np.array([scale.px_per_mm_x, scale.px_per_mm_y])
    moved_px = trajectory.displacement_px[_travels_until(trajectory)]
    if min(np.hypot(*expected_px), np.hypot(*moved_px)) < _FEWEST_PX:
        return None, ()
    expected, moved = (float(np.rad2deg(np.arctan2(y, x))) for x, y in (expected_px, moved_px))
    away_deg = _within_half_a_turn(moved - expected)
    if abs(away_deg) <= _AWAY_DEG:
        return away_deg, ()
    ways: list[Orientation] = [
        way for way in ORIENTATIONS if abs(_within_half_a_turn(upright_angle_deg(moved, way) - expected)) < _AWAY_DEG
    ]
    return away_deg, tuple(ways)


def _travels_until(trajectory: Trajectory) -> int:
    """Give the frame at which the fitted travel ends: the last one whose covariance is known."""
    return trajectory.last_known if trajectory.covariance is None else int(trajectory.covariance.frame[-1])


def _within_half_a_turn(angle_deg: float) -> float:
    return (angle_deg + 180) % 360 - 180


def _at_rest_within_px(trajectory: Trajectory, commanded_mm: float) -> float | None:
    """Upper end of the 95 % interval of the largest displacement, where that is less than any that a bench would measure."""
    known = trajectory.sigma_px < np.inf
    if abs(commanded_mm) < _MOVED_MM or not known.all():
        return None
    farthest_px = float(np.max(np.abs(trajectory.displacement_px) + _SURE * trajectory.sigma_px))
    return farthest_px if farthest_px < _RESTS_PX else None


def _lag_s(recording: Recording, motion: MotionPlan) -> float | None:
    """Mean delay of the positions that were told while the stage moved, behind the profile."""
    log, run_s = recording.stage, recording.plan.run_time_s
    if log is None:
        return None
    during = (log.time_s > 0) & (log.time_s < run_s) & ~log.predicted
    lags: list[float] = []
    for time_s, told_mm in zip(log.time_s[during].tolist(), log.reported_mm[during].tolist(), strict=True):
        here_mm = motion.position_mm(run_s, time_s)
        step_s = 1e-3
        velocity = (motion.position_mm(run_s, time_s + step_s) - motion.position_mm(run_s, time_s - step_s)) / (
            2 * step_s
        )
        if abs(velocity) > _MOVING * abs(motion.velocity_mm_s):
            lags.append((here_mm - told_mm) / velocity)
    return float(np.mean(lags)) if lags else None


def _end_error_mm(recording: Recording, motion: MotionPlan) -> float | None:
    """How far from its target the stage came to rest; None where the run ended before."""
    log, run_s = recording.stage, recording.plan.run_time_s
    if log is None or not len(log) or log.time_s[-1] < run_s or log.predicted[-1]:
        return None
    told: Floats = log.reported_mm
    return float(told[-1] - motion.end_mm(run_s))
