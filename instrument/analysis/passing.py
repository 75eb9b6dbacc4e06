"""An object that passes by, and may be larger than the field: its path and an image that reaches outside the field.

What is in the field changes from frame to frame, and with it the signals of the fringes: their phases tell no path by themselves.
Where the bench is calibrated, the stage's profile does, nearly. From there path and image are refined together. Without, the
refinement begins where the phases lead, which is often too far off; nothing is then said of how sure the path is.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Final

import numpy as np

from instrument.analysis.doubts import crosses_all
from instrument.analysis.find import NOTHING, Found
from instrument.choices import Background, Grid, Method, Normalise, Shape, Tracking
from instrument.joint import refine
from instrument.measurement import Finding, Measurement
from instrument.recording import Recording
from instrument.tracking import Trajectory, as_trajectory, track
from protocols import Floats, InputError

_EXPLAINED: Final = 1.15
"""Misfit up to which path and image explain the values: runs that were refined from a stage's profile had 0.9 to 1.12 where
the path was found, and 1.18 or more where it was not."""

_FAR_PX: Final = 6.0
"""Distance between the path found and the stage's profile from which on one of them may be wrong: 5 px were pulled in, 12 not."""

_FAR_BETTER: Final = 0.97
"""Misfit over that of an object inside from which on one that passes by is believed: its image has more unknown pixels, which
explain more of the noise by themselves."""

_CHANGES: Final = 0.05
"""Change of the total light above which an object may come and go: steady lamps of the benchmarks change it by less."""

_ROOM_PX: Final = 4
"""Room that an object needs beside its path to stay inside the field."""

_MOVED_PX: Final = 2.0
"""Travel below which no more than the border of an object can pass by."""


def refuse_passing(tracking: Tracking, method: Method, shape: Shape, normalise: Normalise) -> None:
    """Refuse methods that see no object pass by.

    Raises:
        InputError: another tracking than ``joint``, another method than ``tv``, a changing shape, or values divided
            by the total light.
    """
    if tracking != "joint" or method != "tv" or shape == "changing" or normalise not in {"auto", "off"}:
        raise InputError(
            saw=f"the region wide with the tracking {tracking}, the method {method}, the shape {shape} and normalise {normalise}",
            expected="the tracking joint, the method tv, a rigid object, and values that are divided by nothing",
            remedy="leave these out, or the region; from Python, reconstruct() takes the region wide with any path, and with "
            "every method but conventional",
        )


def pass_by(recording: Recording, measurement: Measurement, background: Background, grid: Grid) -> Found:
    """Refine path and image of an object that passes by.

    Args:
        recording: the run.
        measurement: its light, of which nothing was found yet.
        background: ``fit`` finds an image of what stands still too.
        grid: as in ``analyse``.

    Raises:
        InputError: the scheme has no position or no image.
    """
    if measurement.scheme.image_rows is None or measurement.scheme.position is None:
        raise InputError(
            saw=f"the region wide for the scheme {measurement.scheme.name}",
            expected="a scheme that sees position and image",
            remedy="leave the region out",
        )
    as_arrived = replace(measurement, light_found=True, normalise="off")
    told = stage_path(recording, as_arrived)
    start = track(as_arrived) if told is None else told
    refined = refine(
        as_arrived,
        start,
        region="wide",
        grid=None if grid == "auto" else int(grid),
        background="fit" if background == "fit" else "none",
    )
    found = Found(
        refined.measurement,
        refined.trajectory,
        refined.image,
        refined.refinements,
        refined.position_misfit,
        refined.usual_misfit,
    )
    return _told(found, told)


def unless_it_passes(
    usual: Callable[[], Found], recording: Recording, as_arrived: Measurement, background: Background, grid: Grid
) -> Found:
    """Find path and image as usual; and where these fail, or are in doubt, those of an object that passes by as the stage tells.

    Where by the stage's profile no object can stay inside the field, one that passes by is looked for first.

    Args:
        usual: function that finds them of an object that is inside the field.
        recording: the run.
        as_arrived: its light, of which nothing was found yet.
        background: as in ``pass_by``.
        grid: likewise.

    Raises:
        InputError, LinAlgError: as ``usual``, where the object is not found to pass by either.
    """
    told = None if as_arrived.scheme.image_rows is None else stage_path(recording, as_arrived)
    if told is None:
        return usual()
    no_room = float(np.ptp(told.displacement_px, axis=0).max()) > recording.plan.image_size - _ROOM_PX
    passing = _tried(recording, as_arrived, background, grid) if no_room else None
    if passing is not None:
        return passing
    found, refused = None, None
    try:
        found = usual()
    except NOTHING as error:
        refused = error
    if not no_room and (found is None or _in_doubt(found)):
        passing = _tried(recording, as_arrived, background, grid)
    if passing is not None and (found is None or _misfit(passing) < _FAR_BETTER * _misfit(found)):
        return passing
    if found is None:
        assert refused is not None  # noqa: S101  (either is there)
        raise refused
    return found


def _tried(recording: Recording, as_arrived: Measurement, background: Background, grid: Grid) -> Found | None:
    """Give path and image of an object that passes by, where there are such that say how sure they are."""
    with suppress(*NOTHING):
        found = pass_by(recording, as_arrived, background, grid)
        if found.trajectory is not None and np.isfinite(found.trajectory.sigma_px).any():
            return found
    return None


def _misfit(found: Found) -> float:
    return np.inf if found.reconstruction is None else found.reconstruction.misfit


def _in_doubt(found: Found) -> bool:
    """Whether an object seems as large as what stays inside the field, or much is unexplained while the light changes."""
    if found.reconstruction is None:
        return False
    return crosses_all(found.reconstruction) or (
        found.measurement.light_change() > _CHANGES and not _misfit(found) < _EXPLAINED
    )


def stage_path(recording: Recording, measurement: Measurement) -> Trajectory | None:
    """Give the path that the stage's profile and the calibration tell; None where one of them is missing, or nothing moves."""
    motion, known = recording.plan.motion, recording.calibration
    scale = None if known is None else known.displacement
    if motion is None or scale is None:
        return None
    frames, frame_time_s = len(measurement), measurement.frame_time_s
    middle_s = (np.arange(frames) + 0.5) * frame_time_s
    place_mm = np.array(motion.positions_mm(recording.plan.run_time_s, middle_s.tolist()))
    place_px: Floats = (place_mm - place_mm[0])[:, None] * np.array([scale.px_per_mm_x, scale.px_per_mm_y])
    if np.ptp(place_px, axis=0).max() < _MOVED_PX:
        return None
    return replace(as_trajectory(place_px, frames, frame_time_s), valid=measurement.valid)


def _told(found: Found, told: Trajectory | None) -> Found:
    """Say what the image is of, and where the path is not to be trusted."""
    path, image = found.trajectory, found.reconstruction
    assert path is not None and image is not None  # noqa: S101, PT018  (refine gave them)
    rows, columns = image.at_patterns.shape
    text = f"the object passes by: its image is {columns} x {rows} px, the field {image.field.width} px"
    sentence = (
        f"{text}: the lamp is taken to be steady, and parts that were in the field for a short time, or late, when fine patterns "
        "were shown, are less sure"
    )
    why = _why_not(path, image.misfit, told, found.refinements)
    if why:
        path = replace(path, sigma_px=np.full_like(path.sigma_px, np.inf), covariance=None)
        sentence = f"{sentence}; {why}"
    finding = Finding("passes by", tuple(range(len(path))), text, sentence)
    measurement = replace(found.measurement, findings=(*found.measurement.findings, finding))
    return replace(found, trajectory=path, measurement=measurement)


def _why_not(path: Trajectory, misfit: float, told: Trajectory | None, refinements: int) -> str:
    """Say why the path may be wrong by more than its uncertainty; nothing where it is to be trusted."""
    if told is None:
        return (
            "the path was begun from the phases of the fringes, which what comes and goes moves too, and may be off by many px: "
            "no uncertainty is stated; calibrate the stage and let the plan move it, or give the path to reconstruct()"
        )
    if not refinements:
        return (
            "the values do not make the stage's profile better, or lead far away from it, so that the path is that profile, and "
            "no uncertainty is stated: take more light, let the object be longer in the field, or calibrate the stage again"
        )
    if not misfit < _EXPLAINED:
        return (
            f"path and image leave {misfit:.2f} times the noise unexplained, so that the path may be wrong and no uncertainty is "
            "stated: look for a lamp that is not steady, a calibration that does not hold, or an object that turns"
        )
    off_px = float(np.hypot(*(path.displacement_px - told.displacement_px).T).max())
    if off_px > _FAR_PX:
        return (
            f"the path found is up to {off_px:.1f} px off the stage's profile, farther than it is sure to be pulled in, so that "
            "no uncertainty is stated: calibrate the stage again, or look whether it missed steps"
        )
    return ""
