"""Path and image of a recording, each by the method that was asked for, as far as its scheme goes."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from instrument.choices import Background, Grid, Method, Shape, Tracking, TrackingMethod
from instrument.joint import LostFrame, grid_of, refine, refine_turn
from instrument.measurement import Measurement
from instrument.reconstruction import Reconstruction, method_of, reconstruct
from instrument.tracking import Trajectory, track, with_start
from protocols import InputError

NOTHING: Final = (InputError, np.linalg.LinAlgError)
"""Errors of a run in which nothing is found."""

_DARK_FRAMES: Final = 8
"""Longest row of frames without a measured one, at either end of a run, over which the path is extrapolated. Beyond a longer row
nothing is claimed."""


@dataclass(frozen=True, eq=False)
class Found:
    """What was found so far."""

    measurement: Measurement
    """The light, with what the run says of the bench."""

    trajectory: Trajectory | None = None
    """The path; None where the scheme has no position."""

    reconstruction: Reconstruction | None = None
    """The image; None where the scheme only tracks."""

    refinements: int = 0
    """Number of refinements of both together."""

    position_misfit: float = np.nan
    """As ``Refined.position_misfit`` says; NaN where nothing was refined."""

    usual_misfit: float = np.nan
    """Likewise."""

    lost_frame: LostFrame | None = None
    """A frame that may be lost; None where none is."""


def find_path(measurement: Measurement, tracking: Tracking, mean_filter: int | None) -> Found:
    """Follow the object, where the scheme shows where it is.

    Args:
        measurement: the light.
        tracking: method by which the path is found; ``joint`` begins with ``smooth``.
        mean_filter: number of neighbouring coefficients that are averaged, for ``per-frame``.
    """
    if measurement.scheme.position is None:
        return Found(measurement)
    way: TrackingMethod = "per-frame" if tracking == "per-frame" else "smooth"
    reference = reference_frame_of(measurement) if tracking == "joint" else 0
    return Found(measurement, track(measurement, way, mean_filter=mean_filter, reference_frame=reference))


def reference_frame_of(measurement: Measurement) -> int:
    """Frame that displacement and image are to refer to: 0, or the first measured one of a run that begins in the dark.

    A scheme that measures where the object is at frame 0 keeps that frame.
    """
    position, first = measurement.scheme.position, int(np.argmax(measurement.valid))
    relative = position is not None and position.period_px is not None and position.ramps is None
    return first if relative and measurement.scheme.image_rows is not None and first > _DARK_FRAMES else 0


def find_image(
    found: Found, tracking: Tracking, method: Method, background: Background, grid: Grid, *, shape: Shape = "rigid"
) -> Found:
    """Make the image along the path, and refine both together where that was asked for.

    Args:
        found: the path.
        tracking: ``joint`` refines.
        method: method by which the image is made.
        background: whether the light of something that stands still is found together with the object.
        grid: image pixels that a pattern pixel has along each axis.
        shape: whether a slow change of the object's shape is found; only where ``joint`` refines and the method is ``tv``.

    Returns:
        Path and image, with the absolute position where the scheme measures one.

    Raises:
        InputError: the object turns, and the method's rows do not.
    """
    trajectory = found.trajectory
    if trajectory is not None and trajectory.angle_deg is not None:
        found = _turned(found.measurement, trajectory, tracking, method)
    elif found.measurement.scheme.image_rows is not None:
        found = _shifted(found, tracking, method, background, grid, shape=shape)
    if found.trajectory is None:
        return found
    return replace(found, trajectory=placed_at(found.measurement, found.trajectory, found.reconstruction))


def _shifted(
    found: Found, tracking: Tracking, method: Method, background: Background, grid: Grid, *, shape: Shape
) -> Found:
    """Make the image of an object that shifts, or stands."""
    measurement, trajectory, chosen = found.measurement, found.trajectory, method_of(method)
    finer = 1 if trajectory is None or not chosen.finer else None if grid == "auto" else int(grid)
    still = background == "fit"
    if trajectory is not None and tracking == "joint":
        of_path = None if grid == "auto" else finer  # the path is the same for all methods
        followed = shape if method == "tv" else "rigid"
        refined = refine(measurement, trajectory, grid=of_path, background=background, shape=followed)
        path = refined.trajectory
        if trajectory.reference_frame or measurement.valid[::-1].argmax() > _DARK_FRAMES:
            path = path.known_where(measurement.valid)
        found = Found(
            refined.measurement,
            path,
            refined.image,
            refined.refinements,
            refined.position_misfit,
            refined.usual_misfit,
            refined.lost_frame,
        )
        if method == "tv":
            return found
        still = chosen.finer and refined.image.still is not None
    if finer is None:
        finer = 1 if found.trajectory is None else grid_of(found.trajectory)
    image = reconstruct(found.measurement, found.trajectory, method, grid=finer, still=still)
    return replace(found, reconstruction=image)


def _turned(measurement: Measurement, trajectory: Trajectory, tracking: Tracking, method: Method) -> Found:
    """Make the image of an object that turns.

    Raises:
        InputError: the method is another one than ``tv``.
    """
    if method != "tv":
        raise InputError(
            saw=f"the method {method} for an object that turns",
            expected="tv, the one whose rows turn with the object",
            remedy='leave the method out, or record with the scheme "moment-hadamard"',
        )
    turned = refine_turn(measurement, trajectory, refined=tracking == "joint")
    return Found(measurement, turned.trajectory, turned.image, turned.refinements)


def placed_at(measurement: Measurement, trajectory: Trajectory, image: Reconstruction | None) -> Trajectory:
    """Give the absolute position where the scheme measures one, with what the images of object and background say of it."""
    if image is not None and image.wide:  # there is no centroid of an object that is not in the field as a whole
        return trajectory
    if image is None:
        return with_start(measurement, trajectory)
    still = None if image.still is None else image.still * image.gain
    return with_start(measurement, trajectory, image=image.at_patterns, still=still)
