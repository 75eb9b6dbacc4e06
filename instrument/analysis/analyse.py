"""The analysis of a recording: path, image, and how good both are."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias, get_args

import numpy as np

from instrument.analysis.causes import numbers_that_end, refuse_endless, refuse_hopeless, refuse_size
from instrument.analysis.merit import Figures, figures_of
from instrument.choices import Method, Tracking
from instrument.joint import refine
from instrument.measurement import Measurement
from instrument.reconstruction import Reconstruction, method_of, reconstruct
from instrument.recording import Recording
from instrument.tracking import Trajectory, track
from protocols import Floats, InputError

OnStep: TypeAlias = Callable[[str, int, int], None]
"""Function that is called with the step that begins, the number of steps done, and the number of all steps."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """A recording and the results of its analysis."""

    recording: Recording
    """Recording that was analysed."""

    tracking: Tracking
    """Method by which the path was found."""

    trajectory: Trajectory | None
    """The path; None where the scheme has no position, so that the object was taken as at rest."""

    reconstruction: Reconstruction | None
    """The image corrected for the motion; None where the scheme only tracks."""

    ignored: Floats | None
    """``(m, m)``: the image without correction for the motion, for comparison; None where there is no image."""

    refinements: int
    """Number of refinements of path and image together."""

    figures: Figures
    """Figures of merit."""

    @property
    def image(self) -> Floats | None:
        """``(m, m)``: the image at frame 0, row = y (down), column = x; None where the scheme only tracks."""
        return None if self.reconstruction is None else self.reconstruction.image

    @staticmethod
    def padded(rows: Floats, frames: int) -> Floats:
        """Append rows of NaN for the frames at the end of the recording that were not analysed, ``(frames, 2)`` in all."""
        return np.pad(rows, ((0, frames - len(rows)), (0, 0)), constant_values=np.nan)


def _tell_nobody(what: str, done: int, total: int) -> None:
    """Ignore the progress."""


def analyse(
    recording: Recording,
    *,
    tracking: Tracking = "joint",
    method: Method = "tv",
    on_step: OnStep | None = None,
) -> Analysis:
    """Track the object, reconstruct its image, and judge both, as far as the recording's scheme goes.

    Args:
        recording: whole or partial recording.
        tracking: method by which the path is found.
        method: method by which the image is made, as in ``reconstruct``.
        on_step: function that is called before each step.

    Raises:
        InputError: no frame is usable, nothing can be found in the values, the object leaves the field, or the tracking or the
            method is unknown.
    """
    if tracking not in get_args(Tracking):
        raise InputError(
            saw=f"the tracking {tracking!r}",
            expected=f"one of {', '.join(get_args(Tracking))}",
            remedy="correct the name",
        )
    method_of(method)
    if isinstance(recording, Recording) and not recording.frame_valid.any():  # pyright: ignore[reportUnnecessaryIsInstance]
        raise InputError(
            saw=f"{len(recording)} frames, none of them valid",
            expected="a recording with usable frames",
            remedy="look at /entry/timing/report in the file for why, and repeat the run",
        )
    tell: OnStep = on_step or _tell_nobody
    started_s = time.perf_counter()
    if isinstance(recording, Recording):  # pyright: ignore[reportUnnecessaryIsInstance] - a script may pass a path
        refuse_size(recording)
    measurement = Measurement.of(recording)
    refuse_hopeless(measurement)
    trajectory: Trajectory | None = None
    reconstruction: Reconstruction | None = None
    ignored: Floats | None = None
    refinements = 0
    with numbers_that_end():
        tell("following the object", 0, 3)
        if measurement.scheme.position is not None:
            trajectory = track(measurement, "per-frame" if tracking == "per-frame" else "smooth")
        tell("reconstructing", 1, 3)
        if measurement.scheme.image_rows is not None:
            if trajectory is not None and tracking == "joint":
                refined = refine(measurement, trajectory)
                trajectory, reconstruction, refinements = refined.trajectory, refined.image, refined.refinements
            if reconstruction is None or method != "tv":
                reconstruction = reconstruct(measurement, trajectory, method)
    refuse_endless(trajectory, reconstruction)
    took_s = time.perf_counter() - started_s
    tell("comparing", 2, 3)
    with numbers_that_end():
        if reconstruction is not None:
            ignored = reconstruct(measurement, None, "conventional").image
        figures = figures_of(measurement, recording.truth, trajectory, reconstruction, took_s)
    tell("done", 3, 3)
    return Analysis(recording, tracking, trajectory, reconstruction, ignored, refinements, figures)
