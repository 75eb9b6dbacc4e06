"""Calibration of real displacement from one moving run: the path that was tracked against the profile that was commanded.

While the stage moves nobody is told where it is as well as at rest, but a profile that the controller keeps says it: at the time
t after the first pattern the stage has gone as far as the trapezoid of the plan says, up to a delay that all patterns share. The
delay shifts the place of all frames alike where the velocity is constant; a run that accelerates must not have one.
"""

from datetime import UTC, datetime
from typing import Final

import numpy as np

from instrument.config import CalibrationPosition, DisplacementSection
from instrument.joint import refine
from instrument.measurement import first_light
from instrument.plan import MotionPlan
from instrument.recording import Recording
from instrument.tracking import Trajectory, track
from protocols import Floats, InputError, Integers

_GROUPS: Final = 9  # groups of frames that the file lists
_LEAST_TRAVEL: Final = 20.0  # standard deviations that the object must have moved by


def displacement_of_run(recording: Recording, date: datetime | None = None) -> DisplacementSection:
    """Fit scale and axis to a moving run.

    Args:
        recording: of a plan with motion, and of a scheme that sees position.
        date: of the calibration; None for now.

    Raises:
        InputError: a plan without motion, a run that cannot be tracked, or one whose image hardly moved.
    """
    motion = recording.plan.motion
    if motion is None:
        raise InputError(
            saw="a recording of an object at rest",
            expected="one of a moving stage",
            remedy="record a plan with [motion], or give --positions-mm for static images",
        )
    measurement = first_light(recording)
    trajectory = track(measurement)
    if measurement.scheme.image_rows is not None:
        trajectory = refine(measurement, trajectory).trajectory
    known = trajectory.covariance
    if known is None:
        raise InputError(
            saw=f"a run of {len(trajectory)} frames, too short for a path with its uncertainty",
            expected="some hundred frames",
            remedy="record more frames",
        )
    _refuse_hardly_moved(trajectory)
    gone_mm = _gone_mm(motion, recording, trajectory, known.frame)
    place_px = trajectory.displacement_px[known.frame]
    solve: Floats = gone_mm / float(gone_mm @ gone_mm)
    slope: Floats = solve @ place_px
    variance = np.einsum("k,akl,l->a", solve, known.covariance_px2, solve)
    residual_px = place_px - gone_mm[:, None] * slope
    shown = np.unique(np.linspace(0, len(known.frame) - 1, _GROUPS).round().astype(int))
    start_mm = motion.position_mm(recording.plan.run_time_s, float(trajectory.time_s[0]))
    sigma_px = trajectory.sigma_px[known.frame]
    return DisplacementSection(
        date=date or datetime.now(UTC),
        image_size=recording.plan.image_size,
        superpixel=recording.plan.superpixel,
        px_per_mm_x=float(slope[0]),
        px_per_mm_y=float(slope[1]),
        covariance=((float(variance[0]), 0.0), (0.0, float(variance[1]))),
        method="moving run",
        rms_residual_px=float(np.sqrt(np.mean(residual_px**2))),
        positions=tuple(
            CalibrationPosition(
                stage_mm=start_mm + float(gone_mm[k]),
                approach="upward" if motion.velocity_mm_s > 0 else "downward",
                shift_px=(float(place_px[k, 0]), float(place_px[k, 1])),
                sigma_px=(float(sigma_px[k, 0]), float(sigma_px[k, 1])),
                residual_px=(float(residual_px[k, 0]), float(residual_px[k, 1])),
            )
            for k in shown.tolist()
        ),
    )


def _gone_mm(motion: MotionPlan, recording: Recording, trajectory: Trajectory, frame: Integers) -> Floats:
    """``(k,)``: distance of the stage from where it was at frame 0."""
    run_s = recording.plan.run_time_s
    first_mm = motion.position_mm(run_s, float(trajectory.time_s[0]))
    return np.array(motion.positions_mm(run_s, trajectory.time_s[frame].tolist())) - first_mm


def _refuse_hardly_moved(trajectory: Trajectory) -> None:
    travel_px, sigma_px = trajectory.displacement_px[-1], trajectory.sigma_px[-1]
    length, error = float(np.hypot(*travel_px)), float(np.hypot(*sigma_px))
    if not length > _LEAST_TRAVEL * error:
        raise InputError(
            saw=f"an image that moved by {length:.2f} +- {error:.2f} px in the run",
            expected=f"at least {_LEAST_TRAVEL:g} times its uncertainty",
            remedy="look whether the stage moved and the object stands on it; record a longer travel, or more light",
        )
