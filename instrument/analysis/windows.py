"""A recording of any length analysed in windows: the path of the whole run, and an image of each window.

Only one window is read and held at a time, and of each frame only its place is kept.
"""

import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, Self

import numpy as np

from instrument.analysis.analyse import OnStep
from instrument.analysis.causes import numbers_that_end, refuse_hopeless
from instrument.analysis.merit import Figures
from instrument.analysis.stored import background_choice
from instrument.choices import Background
from instrument.config import DisplacementSection
from instrument.joint import refine
from instrument.measurement import IDEAL, LightModel, Measurement, first_light
from instrument.numerics import displacement_mse, offset_free_mse, one_blas_thread
from instrument.reconstruction import reconstruct
from instrument.recording import Recording
from instrument.schemes import scheme_of
from instrument.storage import open_recording, recording_info, refuse_unchangeable, refuse_while_written, write_analysis
from instrument.tracking import JoinedPath, Trajectory, Window, track, windows_of
from protocols import Floats, InputError

WINDOW_FRAMES: Final = 50_000
"""Frames of a window, if nobody says otherwise: some 200 MB."""

_NO_CYCLE: Final = 1024
"""Frames that windows of a scheme without Hadamard patterns share."""


@dataclass(frozen=True, eq=False)
class WindowImage:
    """The image of the object from the frames of a window."""

    window: Window
    """The window; all of its frames were used, those too that it shares with the one before."""

    image: Floats
    """``(m, m)``: where the object was at frame 0 of the run, row = y (down), column = x."""

    misfit: float
    """Root mean square of what image and path leave unexplained, over the noise."""

    still: Floats | None = None
    """``(m, m)``: image of what stands still, on the same scale; None where it was not asked for, or not found."""


@dataclass(frozen=True, eq=False)
class Windowed:
    """A run that was analysed in windows."""

    path: Path
    """The recording."""

    trajectory: Trajectory
    """Displacement of every frame of the run."""

    images: tuple[WindowImage, ...]
    """Images of the windows that were asked for."""

    windows: tuple[Window, ...]
    """All windows."""

    figures: Figures
    """Figures of merit of the whole run. The image has none, as there are several."""

    truth_px: Floats | None = None
    """``(frames, 2)``: the true displacement, of a simulated run."""


@dataclass
class _Gathered:
    """What windows add up to."""

    masked: int = 0
    totals: list[float] = field(default_factory=list[float])
    doubts: tuple[str, ...] = ()
    found: tuple[str, ...] = ()
    light: LightModel = IDEAL
    took_s: float = 0.0


@dataclass(frozen=True)
class _Behind:
    """A recording of what stands still, without the object."""

    path: Path
    frames: int

    @classmethod
    def of(cls, path: Path, windows: Sequence[Window]) -> Self:
        """Look at it, before the work.

        Raises:
            InputError: it is being written, cannot be read, or is shorter than a window.
        """
        refuse_while_written(path)
        frames, longest = recording_info(path).frames, max(window.end - window.first for window in windows)
        if frames < longest:
            raise InputError(
                saw=f"a background of {frames} frames, {path}",
                expected=f"as many as a window has, {longest}",
                remedy="record it for longer, by the same plan without [motion] and without the object, or take smaller windows",
            )
        return cls(path, frames)

    def during(self, window: Window) -> Recording:
        """Give the frames of a window, or as many from the first on, which have the same patterns: windows are whole cycles."""
        first = window.first if window.end <= self.frames else 0
        return open_recording(self.path, (first, first + window.end - window.first))


@one_blas_thread()
def analyse_in_windows(
    path: str | Path,
    *,
    window_frames: int = WINDOW_FRAMES,
    images: Collection[int] | None = None,
    background: str | Path | Background = "auto",
    results: str | Path | None = None,
    on_step: OnStep | None = None,
) -> Windowed:
    """Track a recording over all its frames, reconstruct the object from those of each window, and write both into its file.

    In windows of which an image is made path and image are refined together, as ``analyse`` does; in others the path is smooth.
    What the run shows of the bench's light before there is an image is found in the first window and used for all. Windows share
    one cycle of the patterns, m^2 frames for m x m pattern pixels, and begin where the patterns do.

    Args:
        path: file of the recording.
        window_frames: frames of a window at least; rounded up to whole cycles.
        images: numbers of the windows of which an image is made; None for all.
        background: file of a recording of the same patterns without the object, to be subtracted: as long as the run, or as a
            window, when its first frames serve for every window, as patterns come again; or whether the light of something
            that stands still is found together with the object in windows of which an image is made, as in ``analyse``.
        results: a new file for a copy with the analysis; None writes into the recording.
        on_step: function that is called with what begins, the number of windows done, and the number of all.

    Raises:
        InputError: as ``analyse``; the scheme has no position; or there is no such window.
    """
    path = Path(path)
    refuse_unchangeable(path, None if results is None else Path(results))
    fitted, behind = background_choice(background)
    started_s, frame_time_s = time.perf_counter(), 1.0
    info = recording_info(path)
    if info.plan is None or not info.frames:
        raise InputError(
            saw=f"{path} without frames, or of the scheme {info.missing_scheme or 'that it names'}, which is not installed",
            expected="a recording of an installed scheme",
            remedy="install the distribution that offers its scheme, or record anew",
        )
    frames, has_image = info.frames, scheme_of(info.plan).image_rows is not None
    windows = windows_of(frames, window_frames, info.plan.image_size**2 if has_image else _NO_CYCLE)
    wanted = _wanted(images, len(windows), has_image=has_image)
    empty = None if behind is None else _Behind.of(behind, windows)
    whole, gathered = JoinedPath(frames), _Gathered()
    made: list[WindowImage] = []
    light: LightModel | None = None
    scale: DisplacementSection | None = None
    for number, window in enumerate(windows):
        if on_step is not None:
            on_step("following the object", number, len(windows))
        recording = open_recording(path, (window.first, window.end))
        if empty is not None:
            recording = recording.minus(empty.during(window))
        measurement = _lit(recording, light)
        light, frame_time_s = measurement.light, measurement.frame_time_s
        scale = None if recording.calibration is None else recording.calibration.displacement
        _gather(gathered, measurement, window)
        imaged, still = number in wanted, False
        with numbers_that_end():
            own = track(measurement)
            if imaged:  # which refines the path as well
                if on_step is not None:
                    on_step("path and image together", number, len(windows))
                refined = refine(measurement, own, background=fitted)
                measurement, own = refined.measurement, refined.trajectory
                still = refined.image.still is not None
            start_px = whole.add(window, own)
            if imaged:
                made.append(_image(measurement, own, start_px, window, still=still))
    trajectory = replace(whole.trajectory(frame_time_s), scale=scale)
    gathered.light, gathered.took_s = light or IDEAL, time.perf_counter() - started_s
    truth_px = _truth_px(path, frames)
    figures = _figures(trajectory, gathered, made, truth_px)
    done = Windowed(path, trajectory, tuple(made), tuple(windows), figures, truth_px)
    _store(done, window_frames, results)
    if on_step is not None:
        on_step("done", len(windows), len(windows))
    return done


def _wanted(images: Collection[int] | None, windows: int, *, has_image: bool) -> Collection[int]:
    if images is None:
        return range(windows) if has_image else ()
    if not all(0 <= number < windows for number in images) or (images and not has_image):
        raise InputError(
            saw=f"images of the windows {', '.join(map(str, images))}",
            expected=f"windows from 0 on, before {windows}" if has_image else "none: the scheme has no image",
            remedy="ask for windows that there are",
        )
    return images


def _lit(recording: Recording, light: LightModel | None) -> Measurement:
    measurement = Measurement.of(recording)
    refuse_hopeless(measurement)
    if light is None:
        return first_light(measurement)
    return replace(measurement.lit_by(light), light_found=True)


def _gather(gathered: _Gathered, measurement: Measurement, window: Window) -> None:
    own = slice(window.own - window.first, None)
    gathered.masked += int(np.count_nonzero(~measurement.valid[own]))
    if measurement.valid.any():
        gathered.totals.append(float(measurement.total[measurement.valid].mean()))
    where = f"frames {window.first} to {window.end - 1}"
    gathered.found += tuple(f"{where}: {finding.text}" for finding in measurement.findings)
    gathered.doubts += tuple(f"{where}: {finding.sentence}" for finding in measurement.findings)


def _image(measurement: Measurement, path: Trajectory, start_px: Floats, window: Window, *, still: bool) -> WindowImage:
    moved = replace(path, displacement_px=path.displacement_px + start_px)
    found = reconstruct(measurement, moved, "tv", still=still)
    return WindowImage(window, found.at_patterns, found.misfit, found.still)


def _figures(trajectory: Trajectory, gathered: _Gathered, made: list[WindowImage], truth_px: Floats | None) -> Figures:
    totals = np.array(gathered.totals or [1.0])
    x_px, y_px = trajectory.displacement_px[-1].tolist()
    sigma_px = float(np.median(trajectory.sigma_px))
    return Figures(
        frames=len(trajectory),
        frames_masked=gathered.masked,
        travel_px=(x_px, y_px),
        sigma_px=sigma_px if np.isfinite(sigma_px) else None,
        misfit=float(np.median([one.misfit for one in made])) if made else None,
        light_change=float(np.abs(totals / np.median(totals) - 1).max()),
        analysis_s=gathered.took_s,
        light=gathered.light,
        grid=1 if made else None,
        background_share=_background_share(made),
        found=gathered.found,
        doubts=gathered.doubts,
        displacement_mse_px2=None if truth_px is None else displacement_mse(trajectory.displacement_px, truth_px),
        displacement_mse_offset_free_px2=None
        if truth_px is None
        else offset_free_mse(trajectory.displacement_px, truth_px),
    )


def _background_share(made: list[WindowImage]) -> float | None:
    """Share of the light that stands still, of the first window where it was found."""
    for one in made:
        if one.still is not None:
            behind, own = float(one.still.sum()), float(one.image.sum())
            return behind / max(behind + own, 1e-300)
    return None


def _truth_px(path: Path, frames: int) -> Floats | None:
    """``(frames, 2)``: the true displacement, of a simulated run; read in parts."""
    parts: list[Floats] = []
    for first in range(0, frames, WINDOW_FRAMES):
        truth = open_recording(path, (first, min(first + WINDOW_FRAMES, frames))).truth
        if truth is None:
            return None
        parts.append(truth.displacement_px)
    return np.concatenate(parts)


def _store(done: Windowed, window_frames: int, results: str | Path | None) -> None:
    trajectory = done.trajectory
    write_analysis(
        done.path,
        displacement_px=trajectory.displacement_px,
        sigma_px=trajectory.sigma_px,
        displacement_mm=None if trajectory.scale is None else trajectory.displacement_mm,
        sigma_mm=None if trajectory.scale is None else trajectory.sigma_mm,
        image=done.images[0].image if done.images else None,
        still=next((one.still for one in done.images if one.still is not None), None),
        window_images=np.stack([one.image for one in done.images]) if done.images else None,
        window_frames=np.array([[one.window.first, one.window.end] for one in done.images], np.int64),
        table=done.figures.model_dump(mode="json"),
        settings={
            "tracking": "joint" if done.images else "smooth",
            "method": "tv" if done.images else None,
            "frames": len(trajectory),
            "window_frames": window_frames,
            "windows": len(done.windows),
        },
        into=results,
    )
