"""Analysis of a recording in a file: the file is read, analysed, and the result is written into it."""

from pathlib import Path
from typing import get_args

from instrument.analysis.analyse import Analysis, OnStep, analyse
from instrument.analysis.merit import Figures
from instrument.choices import Background, Grid, Method, Normalise, Reach, Shape, Tracking
from instrument.measurement import LightModel
from instrument.recording import Recording
from instrument.storage import open_recording, recording_info, refuse_unchangeable, refuse_while_written, write_analysis
from protocols import Floats, InputError


def analyse_path(
    path: str | Path,
    *,
    tracking: Tracking = "joint",
    method: Method = "tv",
    frames: int | None = None,
    background: str | Path | Background = "auto",
    grid: Grid = "auto",
    mean_filter: int | None = None,
    normalise: Normalise = "auto",
    shape: Shape = "auto",
    region: Reach = "auto",
    results: str | Path | None = None,
    on_step: OnStep | None = None,
) -> Figures:
    """Analyse a recording, write ``/entry/analysis`` into it or into a copy, and give its figures.

    Args:
        path: file of the recording.
        tracking: method by which the path is found.
        method: method by which the image is made, as in ``reconstruct``.
        frames: number of frames, from the first on, that are used; None for all.
        background: file of a recording of the same plan without the object, to be subtracted; or whether the light of something
            that stands still is found together with the object, as in ``analyse``.
        grid: image pixels that a pattern pixel has along each axis, as in ``analyse``.
        mean_filter: of the tracking ``per-frame``, as in ``analyse``.
        normalise: by what values are divided, as in ``analyse``.
        shape: whether a slow change of the object's shape is found, as in ``analyse``.
        region: whether the object passes by, as in ``analyse``.
        results: a new file for a copy with the analysis, which leaves the recording as it is; None writes into the recording.
        on_step: function that is called before each step.

    Raises:
        InputError: the recording cannot be read, is being written or may not be changed, no frame is usable, or the object
            leaves the field.
    """
    fitted, file = background_choice(background)
    recording = recording_to_analyse(path, file, results)
    used = recording if frames is None else recording.first(frames)
    analysis = analyse(
        used,
        tracking=tracking,
        method=method,
        background=fitted,
        grid=grid,
        mean_filter=mean_filter,
        normalise=normalise,
        shape=shape,
        region=region,
        on_step=on_step,
    )
    store(path, recording, analysis, results)
    return analysis.figures


def background_choice(background: str | Path | Background) -> tuple[Background, Path | None]:
    """Tell the words that say whether a background is fitted from the name of a file: a file called so is written ``./fit``."""
    for word in get_args(Background):
        if background == word:
            return word, None
    return "none", Path(background)


def recording_to_analyse(
    path: str | Path, background: str | Path | None = None, results: str | Path | None = None
) -> Recording:
    """Open a recording and subtract a background from it, if one is given.

    Whatever would keep the analysis from being stored is refused here, before the work.

    Args:
        path: of the recording.
        background: of the same plan without the object.
        results: where a copy with the analysis is to go; None for the recording itself.

    Raises:
        InputError: a file cannot be read, is being written, or may not be changed, or the background does not belong to the
            recording.
    """
    refuse_unchangeable(Path(path), None if results is None else Path(results))
    recording = open_recording(path)
    if background is None:
        return recording
    refuse_while_written(Path(background))
    return recording.minus(open_recording(background))


def light_found(path: str | Path) -> LightModel:
    """Give what the analysis of a recording found that its bench does to the light.

    Args:
        path: an analysed recording.

    Raises:
        InputError: the file cannot be read, or was not analysed.
    """
    found = recording_info(path).analysis
    if found is None or "light" not in found.table:
        raise InputError(
            saw=f"{path} without an analysis that says what the bench does to the light",
            expected="an analysed recording by the same bench",
            remedy=f"analyse it first: kinopix analyse {path}",
        )
    return LightModel.model_validate(found.table["light"])


def store(
    path: str | Path,
    recording: Recording,
    analysis: Analysis,
    results: str | Path | None = None,
    *,
    key: str | None = None,
) -> None:
    """Write an analysis into the file of its recording, or a copy of it, with NaN for frames at the end that were not analysed.

    Args:
        path: file of the recording.
        recording: the whole recording.
        analysis: of it, or of its first frames.
        results: a new file for a copy with the analysis; None writes into the recording.
        key: digest of what was asked for, and of which program, by which it is known again.

    Raises:
        InputError: the file cannot be changed.
    """
    found, image = analysis.trajectory, analysis.reconstruction
    frames = len(recording)
    write_analysis(
        path,
        displacement_px=None if found is None else analysis.padded(found.displacement_px, frames),
        sigma_px=None if found is None else analysis.padded(found.sigma_px, frames),
        angle_deg=_of_run(frames, None if found is None else found.angle_deg),
        angle_sigma_deg=_of_run(frames, None if found is None else found.angle_sigma_deg),
        magnification=_of_run(frames, None if found is None else found.magnification),
        magnification_sigma=_of_run(frames, None if found is None else found.magnification_sigma),
        pivot_px=None if found is None else found.pivot_px,
        start_px=None if found is None else found.start_px,
        start_sigma_px=None if found is None else found.start_sigma_px,
        reference_frame=analysis.reference_frame,
        displacement_mm=_in_mm(analysis, frames)[0],
        sigma_mm=_in_mm(analysis, frames)[1],
        image=analysis.image,
        image_grid=1 if image is None else image.grid,
        origin_px=analysis.figures.origin_px or (0, 0),
        still=None if image is None else image.still,
        table=analysis.figures.model_dump(mode="json"),
        settings={
            "tracking": analysis.tracking,
            "method": None if image is None else image.method,
            "frames": analysis.figures.frames,
            "refinements": analysis.refinements,
            "grid": None if image is None else image.grid,
            **({} if key is None else {"key": key}),
        },
        into=results,
    )


def _of_run(frames: int, series: Floats | None) -> Floats | None:
    """Append NaN for the frames at the end of the recording that were not analysed, ``(frames,)`` in all."""
    return None if series is None else Analysis.padded(series[:, None], frames)[:, 0]


def _in_mm(analysis: Analysis, frames: int) -> tuple[Floats | None, Floats | None]:
    """The path along the stage's axis and across it with its uncertainty, for all frames; nothing without a calibration."""
    found = analysis.trajectory
    if found is None or found.scale is None:
        return None, None
    return analysis.padded(found.displacement_mm, frames), analysis.padded(found.sigma_mm, frames)
