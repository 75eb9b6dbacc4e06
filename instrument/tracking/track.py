"""The function that finds a trajectory in a recording."""

from dataclasses import replace
from typing import get_args

from instrument.choices import TrackingMethod
from instrument.measurement import Measurement, first_light
from instrument.recording import Recording
from instrument.schemes import position_of
from instrument.tracking.per_frame import track_per_frame
from instrument.tracking.start import with_start
from instrument.tracking.trajectory import Trajectory
from instrument.tracking.turning import with_angle
from instrument.tracking.whole_run import track_smooth
from protocols import InputError


def track(
    recording: Recording | Measurement,
    method: TrackingMethod = "smooth",
    *,
    reference_frames: int | None = None,
    mean_filter: int | None = None,
    reference_frame: int = 0,
) -> Trajectory:
    """Find the object's displacement in every frame.

    ``smooth`` takes off the light of a background that stands still as the centre of the coefficients' circle, where the object
    moves far enough for that, and the light of the picture before that mirrors in transition let through
    (``measurement.first_light``). ``per-frame`` is the processing that the paper published, and takes off neither.
    A background that was recorded is subtracted beforehand: ``track(recording.minus(background))``.

    Args:
        recording: recording of a scheme that tracks.
        method: ``smooth`` fits one path to all frames together; ``per-frame`` takes each frame by itself, as published.
        reference_frames: for ``per-frame`` only, the number of frames at rest at the start that make the reference; None for 1.
        mean_filter: for ``per-frame`` only, the number of neighbouring signals that are averaged (5 in the paper); None for 1.
        reference_frame: for ``smooth`` only, the frame that displacements are relative to. Schemes that measure a position or an
            angle since frame 0 need 0.

    Raises:
        InputError: no frame is usable, the scheme has no position, the method is unknown, or it does not have these settings.
    """
    given = {"reference_frames": reference_frames, "mean_filter": mean_filter}
    settings = {name: value for name, value in given.items() if value is not None}
    if method == "per-frame" and reference_frame:
        raise InputError(
            saw=f"the reference frame {reference_frame} for the method per-frame, which begins at frame 0",
            expected="settings of the method",
            remedy='leave it out, or ask for method="smooth"',
        )
    if method == "per-frame":
        measurement = Measurement.of(recording)
        return _scaled(_placed(measurement, track_per_frame(measurement, **settings)), recording)
    if method != "smooth":
        raise InputError(
            saw=f"the tracking method {method!r}",
            expected=f"one of {', '.join(get_args(TrackingMethod))}",
            remedy="correct the name",
        )
    if settings:
        raise InputError(
            saw=f"{', '.join(settings)} for the method smooth, which has no such setting",
            expected="settings of the method",
            remedy='leave it out, or ask for method="per-frame"',
        )
    measurement = first_light(recording)
    if not 0 <= reference_frame < len(measurement):
        raise InputError(
            saw=f"the reference frame {reference_frame} in a recording of {len(measurement)} frames",
            expected=f"0 to {len(measurement) - 1}",
            remedy="name a frame of the recording",
        )
    return _scaled(_placed(measurement, track_smooth(measurement, reference_frame)), recording)


def _scaled(trajectory: Trajectory, recording: Recording | Measurement) -> Trajectory:
    """Give a path the scale of the bench that it was recorded on, where a recording tells it."""
    known = recording.calibration if isinstance(recording, Recording) else None
    return trajectory if known is None else replace(trajectory, scale=known.displacement)


def _placed(measurement: Measurement, trajectory: Trajectory) -> Trajectory:
    """Give the absolute position and the angle, where the scheme measures them: both count from frame 0."""
    if trajectory.reference_frame:
        return trajectory
    turn = position_of(measurement.scheme).turn
    placed = with_start(measurement, trajectory)
    return placed if turn is None else with_angle(measurement, placed, turn)
