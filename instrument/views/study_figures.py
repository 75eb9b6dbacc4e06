# pyright: reportUnknownMemberType=false
# matplotlib leaves the type of its **kwargs open.
"""The figures of a study: its curves or, for a table, its rows as points; and its images."""

from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

from instrument.studies import METRICS, Case, Result, Spread, Summary
from instrument.views.style import TRUTH_COLOUR, new_figure, save

_STYLES: Final = (("#0072b2", "o", "-"), ("#d55e00", "s", "--"), ("#009e73", "^", "-."), ("#cc79a7", "D", ":"))
"""Colour (the Okabe-Ito palette), marker and line of each processing, so that a print without colours can be read too."""


def write_study_pictures(result: Result, folder: Path, *, pdf: bool = True) -> list[Path]:
    """Draw a study's figure and its images, each as PNG and, unless told otherwise, as PDF; give the files."""
    if not result.outcomes:
        return []
    figures = {result.study.name: study_figure(result), f"{result.study.name}-images": images_figure(result)}
    return [
        save(figure, folder / f"{name}.{kind}")
        for name, figure in figures.items()
        for kind in ("png", "pdf")
        if pdf or kind == "png"
    ]


def study_figure(result: Result) -> Figure:
    """Draw each figure of merit, with the spread over seeds as error bars."""
    return _curves(result) if result.study.axis is not None else _points(result)


def images_figure(result: Result) -> Figure:
    """Show the image of the first seed for every case and processing, grey from 0 to 1."""
    study, summary = result.study, result.summary
    blocks = _by_curve(study.cases)
    rows = [(curve, processing) for curve in blocks for processing in study.processings]
    columns = max(len(cases) for cases in blocks.values())
    figure = new_figure(1.25 * columns + 1.6, 1.45 * len(rows) + 0.3)
    grid = figure.subplots(len(rows), columns, squeeze=False)
    figure.suptitle("first seed, grey 0 to 1; PSNR: mean of all seeds", fontsize=8)
    for index, (curve, processing) in enumerate(rows):
        for column in range(columns):
            axes: Axes = grid[index, column]
            axes.set_xticks([])
            axes.set_yticks([])
            case = blocks[curve][column] if column < len(blocks[curve]) else None
            image = None if case is None else result.image(case.label, processing)
            if case is None or image is None:
                axes.set_axis_off()
                continue
            axes.imshow(image, cmap="gray", vmin=0, vmax=1, interpolation="nearest")
            axes.set_title(case.label.removeprefix(f"{curve}, "), fontsize=7, pad=2)
            axes.set_xlabel(f"{summary.mean(case.label, processing, 'psnr_db'):.1f} dB", fontsize=7, labelpad=2)
            if column == 0:
                block = curve.replace(", ", ",\n") + "\n" if len(blocks) > 1 else ""
                axes.set_ylabel(block + processing.replace(", ", ",\n"), fontsize=7)
    return figure


def _by_curve(cases: tuple[Case, ...]) -> dict[str, list[Case]]:
    blocks: dict[str, list[Case]] = {}
    for case in cases:
        blocks.setdefault(case.curve, []).append(case)
    return blocks


def _curves(result: Result) -> Figure:
    """Draw figures of merit over the study's axis: a row for each and a column for each curve, or four panels of one curve."""
    summary = result.summary
    metrics, blocks = summary.metrics, _by_curve(result.study.cases)
    if len(blocks) == 1:
        rows = (len(metrics) + 1) // 2
        figure = new_figure(8.4, 2.9 * rows + 0.5)
        panels = figure.subplots(rows, 2, squeeze=False, sharex=True).ravel()
        places = [(metric, curve, panels[k]) for k, metric in enumerate(metrics) for curve in blocks]
        bottom = panels[-2:]
    else:
        figure = new_figure(2.9 * len(blocks) + 1.2, 2.2 * len(metrics) + 0.7)
        grid = figure.subplots(len(metrics), len(blocks), squeeze=False, sharex=True, sharey="row")
        places = [
            (metric, curve, grid[row, column])
            for row, metric in enumerate(metrics)
            for column, curve in enumerate(blocks)
        ]
        bottom = grid[-1]
        for column, curve in enumerate(blocks):
            grid[0, column].set_title(curve, fontsize=10)
    for metric, curve, axes in places:
        _draw_curves(axes, summary, metric, blocks[curve])
        if len(blocks) == 1 or curve == next(iter(blocks)):
            axes.set_ylabel(METRICS[metric].title, fontsize=9)
    axis = result.study.axis
    for axes in bottom:
        axes.set_xlabel("" if axis is None else axis.title, fontsize=9)
    handles, names = places[0][2].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=min(len(names), 2), frameon=False, fontsize=9)
    return figure


def _draw_curves(axes: Axes, summary: Summary, metric: str, cases: list[Case]) -> None:
    axis = summary.study.axis
    for processing, (colour, marker, line) in zip(summary.study.processings, _STYLES, strict=False):
        known = [(case, summary.spreads.get((case.label, processing, metric))) for case in cases]
        drawn = [(case.x or 0.0, spread) for case, spread in known if spread is not None]
        axes.errorbar(
            [x for x, _ in drawn],
            [spread.mean for _, spread in drawn],
            yerr=_bars([spread for _, spread in drawn], METRICS[metric].logarithmic),
            color=colour,
            marker=marker,
            linestyle=line,
            markersize=4,
            linewidth=1.2,
            capsize=2,
            label=processing,
        )
    if METRICS[metric].logarithmic:
        axes.set_yscale("log")
    if axis is not None and axis.logarithmic:
        axes.set_xscale("log")
        ticks = sorted({case.x for case in cases if case.x is not None})
        axes.xaxis.set_major_locator(FixedLocator(ticks))
        axes.xaxis.set_major_formatter(FixedFormatter([f"{tick:g}" for tick in ticks]))
        axes.xaxis.set_minor_locator(NullLocator())
    axes.grid(alpha=0.25, linewidth=0.6)
    axes.tick_params(labelsize=8)


def _bars(spreads: list[Spread], logarithmic: bool) -> list[list[float]]:  # noqa: FBT001 - of the axis
    """Give the lengths of the error bars down and up; on a logarithmic axis they end above 0."""
    down = [min(spread.deviation, 0.7 * spread.mean) if logarithmic else spread.deviation for spread in spreads]
    return [down, [spread.deviation for spread in spreads]]


def _points(result: Result) -> Figure:
    """Draw a line for each row of a table: the paper's figure as a hollow diamond, ours beside it."""
    summary, study = result.summary, result.study
    figure = new_figure(9.2, 6.4)
    panels = figure.subplots(2, 2, sharey=True).ravel()
    place = np.arange(len(study.cases), dtype=np.float64)
    for axes, metric in zip(panels, summary.metrics, strict=False):
        printed = [
            (y, study.paper[case.label, metric])
            for y, case in zip(place, study.cases, strict=True)
            if (case.label, metric) in study.paper
        ]
        for index, processing in enumerate(study.processings):
            colour, marker, _ = _STYLES[index]
            known = [summary.spreads.get((case.label, processing, metric)) for case in study.cases]
            drawn = [(y, spread) for y, spread in zip(place, known, strict=True) if spread is not None]
            axes.errorbar(
                [spread.mean for _, spread in drawn],
                [y + 0.12 * (2 * index - 1) for y, _ in drawn],
                xerr=_bars([spread for _, spread in drawn], METRICS[metric].logarithmic),
                color=colour,
                marker=marker,
                linestyle="none",
                markersize=6,
                capsize=3,
                label=processing,
            )
        axes.plot(
            [value for _, value in printed],
            [y for y, _ in printed],
            linestyle="none",
            marker="D",
            markersize=8,
            markerfacecolor="none",
            markeredgecolor=TRUTH_COLOUR,
            label="paper",
        )
        if METRICS[metric].logarithmic:
            axes.set_xscale("log")
        axes.set_xlabel(METRICS[metric].title)
        axes.set_yticks(place.tolist(), [case.label for case in study.cases])
        axes.grid(alpha=0.25, linewidth=0.6)
    panels[0].invert_yaxis()
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=3, frameon=False)
    return figure
