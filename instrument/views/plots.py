# pyright: reportUnknownMemberType=false
# matplotlib leaves the type of its **kwargs open.
"""Curves over time, with their uncertainty, and the timing of a run."""

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from instrument.views.style import TRUTH_COLOUR, X_COLOUR, Y_COLOUR, new_figure
from protocols import Floats

_AXES: Final = (("x", X_COLOUR, 5.0), ("y", Y_COLOUR, 2.0))
"""Name, colour and width: the second line is thinner, so that both are seen where x and y are the same."""

_BARS: Final = 40
"""Bars to each side of the middle, at most."""


def draw_trajectory(
    axes: Axes,
    time_s: Floats,
    displacement_px: Floats,
    truth_px: Floats | None,
    *,
    px_per_mm: float | None = None,
    sigma_px: Floats | None = None,
) -> None:
    """Draw displacement over time with bands of two standard deviations, the truth as a dashed line over it, and a scale in mm.

    Args:
        axes: where.
        time_s: ``(frames,)`` middle of each frame.
        displacement_px: ``(frames, 2)`` x and y.
        truth_px: ``(frames, 2)`` true displacement; None where it is unknown.
        px_per_mm: image scale of a calibrated bench; None draws no scale in mm.
        sigma_px: ``(frames, 2)`` stated standard deviation; None draws no bands.
    """
    for column, (name, colour, width) in enumerate(_AXES):
        if sigma_px is not None:
            _band(axes, time_s, displacement_px[:, column], sigma_px[:, column], colour)
        axes.plot(time_s, displacement_px[:, column], color=colour, linewidth=width, label=f"{name} measured")
    if truth_px is not None:
        for column, name in enumerate("xy"):
            label = "truth" if name == "x" else None
            axes.plot(time_s, truth_px[:, column], color=TRUTH_COLOUR, linestyle="--", linewidth=0.8, label=label)
    axes.set_xlabel("time, s")
    axes.set_ylabel("displacement, px")
    axes.legend(loc="best", frameon=False)
    axes.grid(alpha=0.25, linewidth=0.6)
    if px_per_mm is not None:
        _add_millimetres(axes, px_per_mm, "displacement, mm")


def _band(axes: Axes, time_s: Floats, middle: Floats, sigma: Floats, colour: str, *, label: str | None = None) -> None:
    """Fill two standard deviations to both sides; where none is known, nothing."""
    known = np.isfinite(sigma) & np.isfinite(middle)
    if known.any():
        reach = np.where(known, 2 * sigma, 0.0)
        low, high = middle - reach, middle + reach
        axes.fill_between(time_s, low, high, where=known.tolist(), color=colour, alpha=0.25, linewidth=0, label=label)


def _add_millimetres(axes: Axes, px_per_mm: float, label: str) -> None:
    low_px, high_px = axes.get_ylim()
    millimetres = axes.twinx()  # drawn once, so that the scales need not follow each other
    millimetres.set_ylim(low_px / px_per_mm, high_px / px_per_mm)
    millimetres.set_ylabel(label)


def draw_deviation(axes: Axes, time_s: Floats, displacement_px: Floats, sigma_px: Floats) -> None:
    """Draw what is left of the displacement when each axis's own parabola is taken away, with bands of two standard deviations.

    On the scale of the whole way, the uncertainty of a good run is thinner than a line. Here it is seen.
    """
    for column, (name, colour, width) in enumerate(_AXES):
        known = np.isfinite(displacement_px[:, column])
        left = np.full(len(time_s), np.nan)
        degree = min(2, int(known.sum()) - 1)
        if degree >= 0:
            scaled = time_s / max(float(time_s[-1]), 1e-30)
            parabola = np.polynomial.Polynomial.fit(scaled[known], displacement_px[known, column], degree)
            left = displacement_px[:, column] - parabola(scaled)
        _band(axes, time_s, left, sigma_px[:, column], colour, label=f"{name}, 2 sigma, stated")
        axes.plot(time_s, left, color=colour, linewidth=width / 2.5, label="_")
    axes.axhline(0, color=TRUTH_COLOUR, linewidth=0.6)
    axes.set_xlabel("time, s")
    axes.set_ylabel("minus a parabola, px")
    axes.legend(loc="best", frameon=False, ncols=2, fontsize=8)
    axes.grid(alpha=0.25, linewidth=0.6)


def trajectory_figure(
    time_s: Floats,
    displacement_px: Floats,
    truth_px: Floats | None,
    *,
    px_per_mm: float | None = None,
    sigma_px: Floats | None = None,
) -> Figure:
    """Show displacement over time and, where its uncertainty is known, what a parabola leaves of it, within that uncertainty.

    Args:
        time_s: ``(frames,)`` middle of each frame.
        displacement_px: ``(frames, 2)`` x and y.
        truth_px: ``(frames, 2)`` true displacement; None where it is unknown.
        px_per_mm: image scale of a calibrated bench, for a second scale in mm.
        sigma_px: ``(frames, 2)`` stated standard deviation; None, or none that is finite, leaves the second panel out.
    """
    if sigma_px is None or not np.isfinite(sigma_px).any():
        figure = new_figure(7, 4)
        draw_trajectory(figure.subplots(), time_s, displacement_px, truth_px, px_per_mm=px_per_mm)
        return figure
    figure = new_figure(7, 5.6)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.7, 1])
    draw_trajectory(above, time_s, displacement_px, truth_px, px_per_mm=px_per_mm, sigma_px=sigma_px)
    above.set_xlabel("")
    draw_deviation(below, time_s, displacement_px, sigma_px)
    return figure


def angle_figure(time_s: Floats, angle_deg: Floats, sigma_deg: Floats | None) -> Figure:
    """Show the angle since frame 0 over time, with a band of two stated standard deviations.

    Args:
        time_s: ``(frames,)`` middle of each frame.
        angle_deg: ``(frames,)`` angle, clockwise in the picture.
        sigma_deg: ``(frames,)`` its standard deviation; None draws no band.
    """
    figure = new_figure(7, 4)
    axes = figure.subplots()
    if sigma_deg is not None and np.isfinite(sigma_deg).all():
        low, high = angle_deg - 2 * sigma_deg, angle_deg + 2 * sigma_deg
        axes.fill_between(time_s, low, high, color=X_COLOUR, alpha=0.2, linewidth=0, label="2 sigma, stated")
    axes.plot(time_s, angle_deg, color=X_COLOUR, label="turn since frame 0, clockwise")
    axes.set_xlabel("time, s")
    axes.set_ylabel("degrees")
    axes.legend(loc="best", frameon=False)
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

    A bar is centred on no deviation, and is at least as wide as the counter's own steps of time, so that none falls between bars.

    Args:
        edge_time_s: ``(frames, patterns_per_frame)`` hardware time of each pattern's edge; NaN where it is missing.
        picture_time_s: time from one pattern to the next as the modulator keeps it.
    """
    figure = new_figure(7, 3.6)
    axes = figure.subplots()
    offset_ns = (np.diff(edge_time_s.ravel()) - picture_time_s) * 1e9
    offset_ns = np.round(offset_ns[np.isfinite(offset_ns)], 3)  # a picosecond: less is the digits' own
    widest = max(10.0, float(np.abs(offset_ns).max(initial=0.0)))
    step = max(_step_of(offset_ns), widest / _BARS)
    most = int(np.ceil(widest / step))
    borders = step * (np.arange(-most, most + 2) - 0.5)
    axes.hist(offset_ns, bins=borders.tolist(), color=X_COLOUR, edgecolor="white", linewidth=0.5)
    axes.set_yscale("symlog", linthresh=1)
    axes.set_xlabel(f"sync period minus {picture_time_s * 1e6:g} us, ns   (bars of {step:.3g} ns)")
    axes.set_ylabel("patterns")
    axes.grid(alpha=0.25, linewidth=0.6, axis="y")
    return figure


def _step_of(values: Floats) -> float:
    """Give the smallest difference between different values; 0 where all are the same."""
    return float(np.diff(np.unique(values)).min(initial=np.inf)) if len(np.unique(values)) > 1 else 0.0
