"""The pictures of one analysis, written as PNG."""

from pathlib import Path

from instrument.analysis import Analysis
from instrument.views.plots import angle_figure, error_figure, image_figure, save, timing_figure, trajectory_figure
from instrument.views.summary import summary_figure
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


def write_pictures(analysis: Analysis, folder: Path, stem: str = "") -> list[Path]:
    """Draw summary, image, trajectory, error (where the truth is known) and timing (where there are edge times).

    Args:
        analysis: analysis to draw.
        folder: folder for the pictures, which is made if it is missing; pictures that exist are replaced.
        stem: beginning of the file names; empty for none.

    Returns:
        The files written, the summary first.
    """
    picture_folder(folder)
    recording, truth = analysis.recording, analysis.recording.truth
    truth_px = truth.displacement_px if truth else None
    truth_image = truth.image if truth else None
    path, image = analysis.trajectory, analysis.image
    figures = {"summary": summary_figure(analysis)}
    if image is not None:
        start_px = None if path is None else path.start_px
        centroid = None if start_px is None else (start_px, recording.plan.image_size)
        figures["image"] = image_figure(image, truth_image, centroid=centroid)
    if analysis.reconstruction is not None and analysis.reconstruction.still is not None:
        figures["background"] = image_figure(analysis.reconstruction.still, None, "what stands still")
    if path is not None:
        figures["trajectory"] = trajectory_figure(
            path.time_s, path.displacement_px, truth_px, None if path.scale is None else path.scale.px_per_mm
        )
        if path.angle_deg is not None:
            figures["angle"] = angle_figure(path.time_s, path.angle_deg, path.angle_sigma_deg)
        if truth_px is not None:
            figures["error"] = error_figure(path.time_s, path.displacement_px - truth_px, path.sigma_px)
    if recording.edge_time_s is not None:
        figures["timing"] = timing_figure(recording.edge_time_s, recording.picture_time_s)
    return [
        save(figure, folder / f"{stem}-{name}.png" if stem else folder / f"{name}.png")
        for name, figure in figures.items()
    ]
