# pyright: reportUnknownMemberType=false
# matplotlib leaves the type of its **kwargs open.
"""The pictures that ``kinopix analyse`` writes beside a recording."""

from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from instrument.analysis import Compared
from protocols import Floats

X_COLOUR: Final = "#0072b2"
"""Colour of everything along x (the Okabe-Ito palette, safe for colour-blind readers)."""

Y_COLOUR: Final = "#d55e00"
"""Colour of everything along y."""

TRUTH_COLOUR: Final = "0.25"
"""Colour of the truth, where it is known."""


def new_figure(width_in: float, height_in: float) -> Figure:
    """Give an empty figure that draws without a screen."""
    figure = Figure(figsize=(width_in, height_in), layout="constrained", dpi=120)
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: Path) -> Path:
    """Write the figure as PNG and return its path."""
    figure.savefig(path)
    return path


def draw_image(axes: Axes, image: Floats, title: str, *, vmax: float | None = None) -> None:
    """Draw an image, row = y down, grey from 0 to ``vmax`` (its own maximum where None)."""
    top = float(np.max(image)) if vmax is None else vmax
    axes.imshow(image, cmap="gray", vmin=0.0, vmax=top or 1.0, interpolation="nearest")
    axes.set_title(title)
    axes.set_xticks([])
    axes.set_yticks([])


def draw_trajectory(
    axes: Axes, time_s: Floats, displacement_px: Floats, truth_px: Floats | None, px_per_mm: float | None = None
) -> None:
    """Draw displacement over time, the truth as a dashed line over it, and millimetres on a second scale where they are known."""
    # The second line is thinner, so that both are seen where x and y are the same.
    for column, (name, colour, width) in enumerate((("x", X_COLOUR, 5.0), ("y", Y_COLOUR, 2.0))):
        axes.plot(time_s, displacement_px[:, column], color=colour, linewidth=width, label=f"{name} measured")
    if truth_px is not None:
        for column, name in enumerate("xy"):
            label = "truth" if name == "x" else None
            axes.plot(time_s, truth_px[:, column], color=TRUTH_COLOUR, linestyle="--", linewidth=0.8, label=label)
    axes.set_xlabel("time, s")
    axes.set_ylabel("displacement, px")
    axes.legend(loc="best", frameon=False)
    if px_per_mm is not None:
        low_px, high_px = axes.get_ylim()
        millimetres = axes.twinx()  # drawn once, so that the scales need not follow each other
        millimetres.set_ylim(low_px / px_per_mm, high_px / px_per_mm)
        millimetres.set_ylabel("displacement, mm")


def image_figure(image: Floats, truth: Floats | None, title: str = "reconstructed, at frame 0") -> Figure:
    """Show a reconstructed image, beside the truth where it is known.

    Args:
        image: ``(m, m)``, row = y down.
        truth: ``(m, m)`` true image; None where it is unknown.
        title: what the image is.
    """
    panels = 1 if truth is None else 2
    figure = new_figure(4.2 * panels, 4.4)
    axes = figure.subplots(1, panels, squeeze=False)[0]
    draw_image(axes[0], image, title)
    if truth is not None:
        draw_image(axes[1], truth, "truth")
    return figure


def compared_figure(compared: Compared) -> Figure:
    """Show an image, the reference, and their difference."""
    figure = new_figure(12.6, 4.6)
    axes = figure.subplots(1, 3, squeeze=False)[0]
    draw_image(axes[0], compared.image, "in motion, moved onto the reference", vmax=1.0)
    draw_image(axes[1], compared.reference, "reference", vmax=1.0)
    draw_image(axes[2], np.abs(compared.image - compared.reference), "difference, without its sign", vmax=1.0)
    found = compared.figures
    figure.suptitle(
        f"PSNR {found.psnr_db:.1f} dB, SSIM {found.ssim_global:.3f}, "
        f"edges {found.edge_width_px:.2f} and {found.reference_edge_width_px:.2f} px wide",
        fontsize=11,
    )
    return figure


def trajectory_figure(
    time_s: Floats, displacement_px: Floats, truth_px: Floats | None, px_per_mm: float | None = None
) -> Figure:
    """Show displacement over time.

    Args:
        time_s: ``(frames,)`` middle of each frame.
        displacement_px: ``(frames, 2)`` x and y.
        truth_px: ``(frames, 2)`` true displacement; None where it is unknown.
        px_per_mm: image scale of a calibrated bench, for a second scale in mm.
    """
    figure = new_figure(7, 4)
    draw_trajectory(figure.subplots(), time_s, displacement_px, truth_px, px_per_mm)
    return figure


def error_figure(time_s: Floats, error_px: Floats, sigma_px: Floats | None) -> Figure:
    """Show the error of the displacement over time, with a band of two stated standard deviations.

    Args:
        time_s: ``(frames,)`` middle of each frame.
        error_px: ``(frames, 2)`` measured minus true displacement.
        sigma_px: ``(frames, 2)`` stated standard deviation; None draws no band.
    """
    figure = new_figure(7, 4)
    axes = figure.subplots(2, 1, sharex=True)
    for column, (name, colour) in enumerate((("x", X_COLOUR), ("y", Y_COLOUR))):
        panel: Axes = axes[column]
        if sigma_px is not None:
            band = 2 * sigma_px[:, column]
            panel.fill_between(time_s, -band, band, color=colour, alpha=0.2, linewidth=0, label="2 sigma, stated")
        panel.plot(time_s, error_px[:, column], color=colour, linewidth=0.9, label=f"error in {name}")
        panel.axhline(0, color=TRUTH_COLOUR, linewidth=0.6)
        panel.set_ylabel("px")
        panel.legend(loc="upper right", frameon=False)
    axes[1].set_xlabel("time, s")
    return figure


def timing_figure(edge_time_s: Floats, picture_time_s: float) -> Figure:
    """Show a histogram of the deviations of the sync periods from the picture time.

    Args:
        edge_time_s: ``(frames, patterns_per_frame)`` hardware time of each pattern's edge; NaN where it is missing.
        picture_time_s: time from one pattern to the next as the modulator keeps it.
    """
    figure = new_figure(7, 3.6)
    axes = figure.subplots()
    offset_us = (np.diff(edge_time_s.ravel()) - picture_time_s) * 1e6
    offset_us = offset_us[np.isfinite(offset_us)]
    widest = max(0.01, float(np.abs(offset_us).max(initial=0.0)))
    axes.hist(offset_us, bins=np.linspace(-widest, widest, 81).tolist(), color=X_COLOUR)
    axes.set_yscale("symlog", linthresh=1)
    axes.set_xlabel(f"sync period minus {picture_time_s * 1e6:g} us, us")
    axes.set_ylabel("patterns")
    return figure
