# pyright: reportUnknownMemberType=false
# matplotlib leaves the type of its **kwargs open.
"""The picture that sums up an analysis."""

from matplotlib.figure import Figure

from instrument.analysis import Analysis
from instrument.views.plots import draw_image, draw_trajectory, new_figure
from protocols import Floats


def summary_figure(analysis: Analysis) -> Figure:
    """Show the image without and with correction for the motion, and the motion itself.

    Panels for which the scheme gives no image or no path are left out.
    """
    truth, path = analysis.recording.truth, analysis.trajectory
    images: list[tuple[Floats, str]] = []
    if analysis.image is not None and analysis.ignored is not None:
        if path is not None:
            images = [(analysis.ignored, "motion ignored"), (analysis.image, "motion measured and taken back")]
        else:
            images = [(analysis.ignored, "inverse transform"), (analysis.image, "reconstructed")]
        if truth is not None:
            images.append((truth.image, "the object, at frame 0"))
        if analysis.reconstruction is not None and analysis.reconstruction.still is not None:
            images.append((analysis.reconstruction.still, "what stands still"))
    rows = int(bool(images)) + int(path is not None)
    figure = new_figure(3.9 * max(2, len(images)), 3.7 * rows)
    grid = figure.add_gridspec(rows, max(1, len(images)))
    for column, (image, title) in enumerate(images):
        draw_image(figure.add_subplot(grid[0, column]), image, title)
    if path is not None:
        truth_px = None if truth is None else truth.displacement_px
        scale = None if path.scale is None else path.scale.px_per_mm
        draw_trajectory(figure.add_subplot(grid[-1, :]), path.time_s, path.displacement_px, truth_px, scale)
    figure.suptitle(analysis.figures.caption(), fontsize=11)
    return figure
