"""The pictures of one analysis, written as PNG, PDF or SVG."""

from pathlib import Path

from matplotlib.figure import Figure

from instrument.analysis import Analysis
from instrument.storage import recording_info
from instrument.views.images import RELATIVE, TRANSMISSION, image_figure
from instrument.views.plots import angle_figure, error_figure, timing_figure, trajectory_figure
from instrument.views.recording_table import about_in_words, plan_in_words
from instrument.views.style import PictureFormat, add_foot, save
from instrument.views.summary import stated_sigma_px, summary_figure
from protocols import InputError


def picture_folder(folder: Path) -> Path:
    """Make the folder if it is missing.

    Raises:
        InputError: the folder cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            saw=f"{folder}, which is no folder and cannot be made one: {error.strerror}",
            expected="a folder for the pictures",
            remedy="name another folder",
        ) from error
    return folder


def write_pictures(analysis: Analysis, folder: Path, stem: str = "", kind: PictureFormat = "png") -> list[Path]:
    """Draw summary, image, trajectory, error (where the truth is known) and timing (where there are edge times).

    Each says in its foot which run it is of, when and how it was recorded, how it was analysed, and what is doubtful about it.

    Args:
        analysis: analysis to draw.
        folder: folder for the pictures, which is made if it is missing; pictures that exist are replaced.
        stem: beginning of the file names; empty for none.
        kind: PNG to look at; PDF or SVG to print.

    Returns:
        The files written, the summary first.
    """
    picture_folder(folder)
    figures, foot = _figures(analysis), foot_of(analysis)
    doubts = _doubts(analysis)
    for figure in figures.values():
        add_foot(figure, foot, doubts)
    return [
        save(figure, folder / f"{stem}-{name}.{kind}" if stem else folder / f"{name}.{kind}")
        for name, figure in figures.items()
    ]


def _figures(analysis: Analysis) -> dict[str, Figure]:
    recording, truth_px = analysis.recording, analysis.truth_px
    path, image = analysis.trajectory, analysis.image
    scale = None if path is None or path.scale is None else path.scale.px_per_mm
    size = recording.plan.image_size
    grey = RELATIVE if recording.photon_counts else TRANSMISSION
    figures = {"summary": summary_figure(analysis)}
    if image is not None:
        figures["image"] = image_figure(
            image,
            analysis.true_image,
            f"reconstructed, at frame {analysis.reference_frame}",
            size_px=size,
            px_per_mm=scale,
            start_px=None if path is None else path.start_px,
            grey=grey,
            edges_px=None if analysis.reconstruction is None else analysis.reconstruction.edges_px,
        )
    if analysis.reconstruction is not None and analysis.reconstruction.still is not None:
        still = analysis.reconstruction.still
        figures["background"] = image_figure(still, None, "what stands still", size_px=size, px_per_mm=scale, grey=grey)
    if path is not None:
        figures["trajectory"] = trajectory_figure(
            path.time_s, path.displacement_px, truth_px, px_per_mm=scale, sigma_px=stated_sigma_px(analysis)
        )
        if path.angle_deg is not None:
            figures["angle"] = angle_figure(path.time_s, path.angle_deg, path.angle_sigma_deg)
        if truth_px is not None:
            figures["error"] = error_figure(path.time_s, path.displacement_px - truth_px, stated_sigma_px(analysis))
    if recording.edge_time_s is not None:
        figures["timing"] = timing_figure(recording.edge_time_s, recording.picture_time_s)
    return figures


def foot_of(analysis: Analysis) -> str:
    """Say in a line what a picture of an analysis is of: run, date, what it is about, plan, method, program."""
    recording, image = analysis.recording, analysis.reconstruction
    how = [] if analysis.trajectory is None else [f"path: {analysis.tracking}"]
    how += [] if image is None else [f"image: {image.method}"]
    of_file, program = _of_file(recording.path)
    about = about_in_words(recording.plan)
    return " | ".join([*of_file, *([about] if about else []), plan_in_words(recording.plan), ", ".join(how), *program])


def foot_of_file(path: Path) -> str:
    """Say in a line what a picture of a file is of: run, date, program."""
    of_file, program = _of_file(path)
    return " | ".join([*of_file, *program])


def _of_file(path: Path | None) -> tuple[list[str], list[str]]:
    """Name and date of a recording, and the program that wrote it, as far as its file tells."""
    if path is None:
        return [], []
    try:
        info = recording_info(path)
    except InputError:  # it has gone since
        return [path.name], []
    return [path.name, info.start_time[:16].replace("T", " ") + " UTC"], [f"{info.program} {info.version}"]


def _doubts(analysis: Analysis) -> list[str]:
    masked = analysis.figures.frames_masked
    told = [f"{masked} of {analysis.figures.frames} frames are masked and left out"] if masked else []
    return [*told, *analysis.figures.doubts]
