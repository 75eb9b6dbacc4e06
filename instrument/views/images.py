# pyright: reportUnknownMemberType=false
# matplotlib leaves the type of its **kwargs open.
"""Images, with their axes, their scale and what their grey means."""

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from instrument.analysis import Compared
from instrument.views.style import X_COLOUR, Y_COLOUR, new_figure
from protocols import Floats

_BAR_SHARE: Final = 0.3
"""Longest scale bar, as a share of the field's side."""

RELATIVE: Final = "relative to the brightest pixel"
"""What grey means for photon counts, which have no absolute scale."""

TRANSMISSION: Final = "transmission"
"""What grey means otherwise."""


def draw_image(
    axes: Axes,
    image: Floats,
    title: str,
    *,
    vmax: float | None = None,
    size_px: int | None = None,
    px_per_mm: float | None = None,
    bar: bool = True,
    edges_px: tuple[float, float, float, float] | None = None,
) -> None:
    """Draw an image in px of the field, with a scale bar and its grey scale stated.

    Args:
        axes: where.
        image: ``(m, m)``, row = y down; or ``(rows, columns)`` of a wide one.
        title: what the image is.
        vmax: value that is white; None takes the image's own maximum.
        size_px: px a side of the field; None takes a px for each pixel of the image.
        px_per_mm: scale of a calibrated bench, for a bar in mm.
        bar: whether there is a scale bar.
        edges_px: left, right, lower and upper edge of an image that is larger than the field, whose border is then drawn; None of
            one that is the field's.
    """
    top = float(np.max(image)) if vmax is None else vmax
    side = len(image) if size_px is None else size_px
    edges = (-0.5, side - 0.5, side - 0.5, -0.5)
    edges = edges_px or edges
    axes.imshow(image, cmap="gray", vmin=0.0, vmax=top or 1.0, interpolation="nearest", extent=edges)
    axes.set_title(title, fontsize=11)
    ticks = np.arange(
        0, side + 1, max(1, side // 4)
    ).tolist()  # fields are powers of two; fixed ones are drawn in half the time
    axes.set_xticks(ticks if edges_px is None else _ticks(edges[0], edges[1], side))
    axes.set_yticks(ticks if edges_px is None else _ticks(edges[3], edges[2], side))
    axes.tick_params(labelsize=8)
    axes.set_xlim(edges[0], edges[1])
    axes.set_ylim(edges[2], edges[3])
    axes.set_xlabel(f"x, px   (grey 0 to {top:.3g})", fontsize=9)
    axes.set_ylabel("y, px", fontsize=9)
    if edges_px is not None:
        axes.plot(
            [-0.5, side - 0.5, side - 0.5, -0.5, -0.5],
            [-0.5, -0.5, side - 0.5, side - 0.5, -0.5],
            color=X_COLOUR,
            linestyle="--",
            linewidth=1.2,
            label="the field at this frame",
        )
        axes.legend(loc="lower left", fontsize=7, framealpha=0.7)
    if bar:
        draw_bar(axes, side, px_per_mm, at_px=(edges[1], edges[2]))


def _ticks(low: float, high: float, side: int) -> list[float]:
    """Multiples of a quarter of the field between two edges; of half, or all of it, where there would be many."""
    step = max(1, side // 4) * (1 if high - low < 2.5 * side else 2)
    return [float(tick) for tick in np.arange(np.ceil(low / step) * step, high, step)]


def draw_bar(axes: Axes, side_px: int, px_per_mm: float | None, at_px: tuple[float, float] | None = None) -> None:
    """Draw a scale bar of 1, 2 or 5 times a power of ten into the lower right corner, in mm where the scale is known.

    Args:
        axes: where.
        side_px: px a side of the field.
        px_per_mm: scale of a calibrated bench.
        at_px: x and y of the lower right corner; None for that of the field.
    """
    unit, scale = ("px", 1.0) if px_per_mm is None else ("mm", px_per_mm)
    length = round_length(_BAR_SHARE * side_px / scale)
    corner_x, corner_y = at_px or (side_px - 0.5, side_px - 0.5)
    right, low = corner_x - 0.05 * side_px, corner_y - 0.07 * side_px
    outline = [withStroke(linewidth=3.5, foreground="black")]
    left = right - length * scale
    axes.plot([left, right], [low, low], color="white", linewidth=2.0, path_effects=outline, label="_scale bar")
    axes.text(
        (left + right) / 2,
        low - 0.02 * side_px,
        f"{length:g} {unit}",
        color="white",
        fontsize=8,
        ha="center",
        va="bottom",
        path_effects=outline,
    )


def round_length(longest: float) -> float:
    """Give the longest of 1, 2 and 5 times a power of ten that is not above ``longest``."""
    power = 10.0 ** np.floor(np.log10(longest))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= longest * (1 + 1e-9)))


def mark_centroid(axes: Axes, start_px: Floats) -> None:
    """Mark the object's centroid by a cross, and say so.

    Args:
        axes: where an image is drawn in px of the field.
        start_px: ``(2,)`` x and y, in px of the field.
    """
    x, y = start_px.tolist()
    axes.plot(
        [x], [y], marker="+", markersize=12, markeredgewidth=1.5, color=Y_COLOUR, linestyle="none", label="centroid"
    )
    axes.legend(loc="upper right", fontsize=8, framealpha=0.8)


def image_figure(
    image: Floats,
    truth: Floats | None,
    title: str = "reconstructed, at frame 0",
    *,
    size_px: int | None = None,
    px_per_mm: float | None = None,
    start_px: Floats | None = None,
    grey: str = TRANSMISSION,
    edges_px: tuple[float, float, float, float] | None = None,
) -> Figure:
    """Show a reconstructed image with its grey scale, beside the truth where it is known.

    Args:
        image: ``(m, m)``, row = y down.
        truth: true image; None where it is unknown.
        title: what the image is.
        size_px: px a side of the field; None takes a px for each pixel.
        px_per_mm: scale of a calibrated bench.
        start_px: ``(2,)`` x and y of the object's centroid in px of the field, to mark it.
        grey: what grey means.
        edges_px: of an image that is larger than the field, as in ``draw_image``.
    """
    panels = 1 if truth is None else 2
    figure = new_figure(4.6 * panels + 0.7, 4.6)
    axes = figure.subplots(1, panels, squeeze=False)[0]
    top = float(np.max(image)) or 1.0
    draw_image(axes[0], image, title, size_px=size_px, px_per_mm=px_per_mm, edges_px=edges_px)
    if start_px is not None:
        mark_centroid(axes[0], start_px)
    if truth is not None:
        draw_image(axes[1], truth, "truth", size_px=size_px, px_per_mm=px_per_mm)
    scale = figure.colorbar(axes[0].get_images()[0], ax=axes.tolist(), shrink=0.8, pad=0.02, ticks=[0.0, top / 2, top])
    scale.set_label(grey if truth is None else f"{grey}, white at {top:.3g}", fontsize=9)
    scale.ax.tick_params(labelsize=8)
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
