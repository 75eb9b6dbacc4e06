# pyright: reportUnknownMemberType=false
# matplotlib leaves the type of its **kwargs open.
"""The picture that sums up an analysis."""

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from instrument.analysis import Analysis
from instrument.tracking import Trajectory
from instrument.views.images import draw_image, mark_centroid
from instrument.views.plots import draw_deviation, draw_trajectory
from instrument.views.style import new_figure
from protocols import Floats

_MOVES_PX: Final = 1.0
"""Displacement from which on an object is said to move."""


def summary_figure(analysis: Analysis) -> Figure:
    """Show the image without and with correction for the motion, and the motion itself with its uncertainty.

    Panels for which the scheme gives no image or no path are left out.
    """
    path = analysis.trajectory
    scale = None if path is None or path.scale is None else path.scale.px_per_mm
    images = _images(analysis)
    sigma_px = stated_sigma_px(analysis)
    heights = [3.9] * bool(images) + [3.4] * (path is not None) + [1.9] * (sigma_px is not None)
    figure = new_figure(4.1 * max(2, len(images)), sum(heights))
    grid = figure.add_gridspec(len(heights), max(1, len(images)), height_ratios=heights)
    for column, (image, title) in enumerate(images):
        axes = figure.add_subplot(grid[0, column])
        size, edges_px = analysis.recording.plan.image_size, None
        if image is analysis.image and analysis.reconstruction is not None:
            edges_px = analysis.reconstruction.edges_px
        draw_image(axes, image, title, size_px=size, px_per_mm=scale, edges_px=edges_px)
        if image is analysis.image and path is not None and path.start_px is not None:
            mark_centroid(axes, path.start_px)
    if path is not None:
        above = figure.add_subplot(grid[int(bool(images)), :])
        draw_trajectory(above, path.time_s, path.displacement_px, analysis.truth_px, px_per_mm=scale, sigma_px=sigma_px)
        if sigma_px is not None:
            above.set_xlabel("")
            draw_deviation(figure.add_subplot(grid[-1, :], sharex=above), path.time_s, path.displacement_px, sigma_px)
    figure.suptitle(analysis.figures.caption(), fontsize=11)
    return figure


def _images(analysis: Analysis) -> list[tuple[Floats, str]]:
    """The images to show, with titles that fit the run."""
    path, true_image = analysis.trajectory, analysis.true_image
    if analysis.image is None or analysis.ignored is None:
        return []
    if path is None:
        images = [(analysis.ignored, "inverse transform"), (analysis.image, "reconstructed")]
    elif farthest_px(path) < _MOVES_PX:
        images = [
            (analysis.ignored, "taken as at rest"),
            (analysis.image, f"moved {farthest_px(path):.2f} px, taken back"),
        ]
    else:
        images = [(analysis.ignored, "motion ignored"), (analysis.image, "motion measured and taken back")]
    if true_image is not None:
        images.append((true_image, "the object, at frame 0"))
    if analysis.reconstruction is not None and analysis.reconstruction.still is not None:
        images.append((analysis.reconstruction.still, "what stands still"))
    return images


def farthest_px(path: Trajectory) -> float:
    """Give the largest displacement of a path."""
    return float(np.max(np.hypot(*path.displacement_px.T), initial=0.0))


def stated_sigma_px(analysis: Analysis) -> Floats | None:
    """Give the path's uncertainty where the analysis states one: of too few frames it is not to be shown either."""
    path = analysis.trajectory
    if path is None or analysis.figures.sigma_px is None or not np.isfinite(path.sigma_px).any():
        return None
    return path.sigma_px
