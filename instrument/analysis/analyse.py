"""The analysis of a recording: path, image, and how good both are."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np

from instrument.analysis.asked import refuse_choices
from instrument.analysis.causes import numbers_that_end, refuse_beyond, refuse_endless, refuse_hopeless, refuse_size
from instrument.analysis.explanations import explained
from instrument.analysis.find import Found, find_image, find_path
from instrument.analysis.leaving import crossing, follow
from instrument.analysis.merit import Figures, figures_of
from instrument.analysis.passing import pass_by, unless_it_passes
from instrument.analysis.second_look import in_step_first, surely_slipped
from instrument.analysis.stage_figures import stage_figures
from instrument.choices import Background, Grid, Method, Normalise, Reach, Shape, Tracking
from instrument.measurement import LightModel, Measurement, Slips, first_light, usable_frames
from instrument.reconstruction import Reconstruction, reconstruct
from instrument.recording import Recording
from instrument.shown import card, curves, grey, line
from instrument.storage import open_recording
from instrument.tracking import Trajectory
from protocols import Floats, InputError
from protocols.field_docs import with_fields

OnStep: TypeAlias = Callable[[str, int, int], None]
"""Function that is called with the step that begins, the number of steps done, and the number of all steps."""


@with_fields
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

    light: LightModel
    """What the bench does to the light, with the numbers that the run determined."""

    measurement: Measurement
    """The values as they were taken: mended, corrected by that light, each of the pattern that was shown."""

    figures: Figures
    """Figures of merit."""

    @property
    def image(self) -> Floats | None:
        """``(grid m, grid m)``: the image at ``reference_frame``, row = y down; None where the scheme only tracks.

        Of an object that passes by it is larger, as ``Reconstruction.image`` says.
        """
        return None if self.reconstruction is None else self.reconstruction.image

    @property
    def reference_frame(self) -> int:
        """Frame that displacements are relative to, and that the image shows: 0, or a later one, as ``Trajectory`` says."""
        return 0 if self.trajectory is None else self.trajectory.reference_frame

    @property
    def truth_px(self) -> Floats | None:
        """``(frames, 2)``: the true displacement, relative to ``reference_frame``; None where it is unknown."""
        truth = self.recording.truth
        return None if truth is None else truth.displacement_px - truth.displacement_px[self.reference_frame]

    @property
    def true_image(self) -> Floats | None:
        """``(m, m)``: the true image; None where it is unknown at ``reference_frame``."""
        truth = self.recording.truth
        return None if truth is None or self.reference_frame else truth.image

    def __repr__(self) -> str:
        """Say in one line how good it is."""
        doubts = len(self.figures.doubts)
        told = f"{doubts} doubt{'s' * (doubts != 1)}" if doubts else ""
        return line("Analysis", self.figures.caption(), f"tracking {self.tracking}", told)

    def _repr_html_(self) -> str:
        """Show in a notebook its figures, its doubts, image and path."""
        rows = self.figures.rows() | {f"doubt {k}": text for k, text in enumerate(self.figures.doubts, 1)}
        path = self.trajectory
        image = "" if self.image is None else grey(self.image, "the reconstructed image")
        drawn = ""
        if path is not None:
            sigma_px = None if self.figures.sigma_px is None else path.sigma_px
            drawn = curves(path.time_s, path.displacement_px, sigma_px, "displacement x, y", "px; x blue, y orange")
        return card("Analysis", rows, image, drawn)

    @staticmethod
    def padded(rows: Floats, frames: int) -> Floats:
        """Append rows of NaN for the frames at the end of the recording that were not analysed, ``(frames, 2)`` in all."""
        return np.pad(rows, ((0, frames - len(rows)), (0, 0)), constant_values=np.nan)


def _tell_nobody(what: str, done: int, total: int) -> None:
    """Ignore the progress."""


def _why(recording: Recording) -> str:
    """Give the first note of the timing report, if there is one."""
    notes = () if recording.timing is None else recording.timing.notes
    return f" ({notes[0]})" if notes else ""


def _lit(measurement: Measurement, tracking: Tracking, normalise: Normalise) -> Measurement:
    """Find out what the run shows of the bench's light; as published, nobody asks it."""
    if tracking != "per-frame":
        return first_light(replace(measurement, normalise=normalise))
    return replace(measurement, light_found=True, normalise="frame" if normalise == "auto" else normalise)


def _refuse_unusable(recording: Recording) -> None:
    """Refuse a recording without a usable frame, and values beyond all measure.

    Raises:
        InputError: in both cases.
    """
    if not usable_frames(recording).any():
        raise InputError(
            saw=f"{len(recording)} frames, none of them valid" + _why(recording),
            expected="a recording with usable frames",
            remedy="look at /entry/timing/report in the file for why, and repeat the run",
        )
    refuse_size(recording)


def analyse(
    recording: Recording | str | Path,
    *,
    tracking: Tracking = "joint",
    method: Method = "tv",
    background: Background = "auto",
    grid: Grid = "auto",
    mean_filter: int | None = None,
    normalise: Normalise = "auto",
    shape: Shape = "auto",
    region: Reach = "auto",
    on_step: OnStep | None = None,
) -> Analysis:
    """Track the object, reconstruct its image, and judge both, as far as the recording's scheme goes.

    Args:
        recording: whole or partial recording, or its file.
        tracking: method by which the path is found.
        method: method by which the image is made, as in ``reconstruct``.
        background: whether the light of something that stands still is found together with the object: ``auto`` finds out
            whether there is any. Where a background was recorded and subtracted, ``auto`` looks for no other.
        grid: image pixels that a pattern pixel has along each axis: ``auto`` takes 2 where the motion supports it.
        mean_filter: for the tracking ``per-frame`` only: number of neighbouring coefficients that are averaged, 5 in the paper.
        normalise: by what values are divided against a lamp that changes: the total light ``smoothed`` over frames, each
            ``frame``'s own as published, or nothing (``off``); ``auto`` goes with the tracking.
        shape: whether it is found how the object slowly turns and grows: where the values show it (``auto``), never (``rigid``),
            or in any case (``changing``). With the tracking ``joint`` and the method ``tv`` alone.
        region: ``inside`` for an object that is inside the field in most frames, and may leave it or come into it. ``wide`` for
            one that passes by, and may be larger than the field: its image then reaches outside. The lamp must be steady, and the
            path is begun from the stage's profile, where the bench is calibrated. With ``joint`` and ``tv`` alone. ``auto`` takes
            it to pass by where a calibrated stage tells so, and its values are explained by nothing else; but not where its light
            falls or rises as that of an object which leaves or comes in.
        on_step: function that is called before each step.

    Raises:
        InputError: the file cannot be read, no frame is usable, nothing can be found in the values, the object leaves the field,
            tracking, method, shape or region are unknown, or a change of shape, or the region ``wide``, is asked of a method
            that knows none.
    """
    refuse_choices(
        tracking=tracking, mean_filter=mean_filter, method=method, normalise=normalise, shape=shape, region=region
    )
    if isinstance(recording, str | Path):
        recording = open_recording(recording)
    tell: OnStep = on_step or _tell_nobody
    started_s = time.perf_counter()
    if isinstance(recording, Recording):  # pyright: ignore[reportUnnecessaryIsInstance] - a script may pass a path
        _refuse_unusable(recording)
    measurement = arrived = Measurement.of(recording)
    refuse_hopeless(measurement, recording if isinstance(recording, Recording) else None)  # pyright: ignore[reportUnnecessaryIsInstance]
    wanted = "none" if background == "auto" and recording.background is not None else background
    with numbers_that_end():
        tell("following the object", 0, 3)
        crossed = None

        def screen(slips: Slips) -> Measurement:
            """Take the values as they stand by some shifts."""
            return replace(Measurement.of(recording, slips), normalise=normalise)

        if tracking == "joint" and region != "wide":
            measurement = surely_slipped(measurement, screen)
        if tracking == "joint" and method == "tv" and region != "wide":
            measurement, crossed = in_step_first(replace(measurement, normalise=normalise), crossing, screen)
        if region == "wide":
            tell("reconstructing", 1, 3)
            found = pass_by(recording, measurement, wanted, grid)
        elif crossed is None:

            def find(run: Measurement) -> Found:
                """Find path and image."""
                path = find_path(_lit(run, tracking, normalise), tracking, mean_filter)
                refuse_beyond(path.measurement, path.trajectory)
                tell("reconstructing", 1, 3)
                return find_image(path, tracking, method, wanted, grid, shape=shape)

            way = partial(explained, measurement, find, screen) if tracking == "joint" else partial(find, measurement)
            if (
                region == "auto"
                and tracking == "joint"
                and method == "tv"
                and normalise in {"auto", "off"}
                and shape != "changing"
            ):
                way = partial(unless_it_passes, way, recording, arrived, wanted, grid)
            found = way()
            measurement = found.measurement
        else:
            tell("reconstructing", 1, 3)
            found = follow(crossed, measurement.valid, wanted, grid, shape=shape)
    refuse_endless(found.trajectory, found.reconstruction)
    trajectory, reconstruction = found.trajectory, found.reconstruction
    known = recording.calibration if isinstance(recording, Recording) else None  # pyright: ignore[reportUnnecessaryIsInstance]
    if trajectory is not None and known is not None:
        trajectory = replace(trajectory, scale=known.displacement)
    took_s = time.perf_counter() - started_s
    tell("comparing", 2, 3)
    with numbers_that_end():
        ignored = None if reconstruction is None else reconstruct(measurement, None, "conventional").image
        stage = None if trajectory is None else stage_figures(recording, trajectory)
        figures = figures_of(found.measurement, recording.truth, trajectory, reconstruction, took_s, stage=stage)
    tell("done", 3, 3)
    used = found.measurement
    return Analysis(
        recording, tracking, trajectory, reconstruction, ignored, found.refinements, used.light, used, figures
    )
