"""The tables of a study: in the terminal, as Markdown in its page of the documents, and as CSV."""

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from rich.table import Table

from instrument.studies import METRICS, Result, Spread, Summary
from instrument.views.terminal import plain

_PAPER: Final = "paper"


def study_tables(result: Result) -> list[Table]:
    """Give a table for each figure of merit: the paper's figure, where it prints one, and each processing's mean and spread."""
    summary, tables = result.summary, list[Table]()
    for metric in summary.metrics:
        head, rows = _cells(summary, metric)
        table = Table(title=plain(METRICS[metric].title), title_justify="left")
        table.add_column("")
        for name in head:
            table.add_column(plain(name), justify="right")
        for row in rows:
            table.add_row(*(plain(cell) for cell in row))
        tables.append(table)
    return tables


def study_page(result: Result, pictures: Sequence[str]) -> str:
    """Write the page of a study.

    Args:
        result: the study, carried out.
        pictures: file names of its pictures, beside the page.
    """
    study, summary = result.study, result.summary
    command = f"kinopix reproduce {study.name} --seeds {result.seeds}"
    how = f"`{command}` prints these tables and draws these figures; with `--docs docs/results` it writes this page. "
    how += f"Mean ± standard deviation of a single seed, over the seeds 0 to {result.seeds - 1}."
    parts = [f"# {study.title}", how, study.about]
    for metric in summary.metrics:
        head, rows = _cells(summary, metric)
        lines = [["", *head], ["---", *("---:" for _ in head)], *rows]
        parts.append(f"**{METRICS[metric].title}**\n\n" + "\n".join("| " + " | ".join(line) + " |" for line in lines))
    parts += [f"![{study.title}]({name})" for name in pictures]
    parts.append("## What the paper says, and what is so here")
    parts.append("\n".join(f"- {_verdict(claim.holds)}: {claim.text}" for claim in study.claims(summary)))
    parts += ["## Where we differ, and why", study.differences]
    if result.failures:
        parts.append("Points that failed are left out: " + "; ".join(result.failures))
    return "\n\n".join(parts) + "\n"


def study_index(results: Sequence[tuple[str, str]]) -> str:
    """Write the page that leads to those of the studies, given by name and title."""
    lines = "\n".join(f"- [{title}]({name}.md)" for name, title in results)
    text = """# Results

The tables and figures of Li et al., Opt. Express (2023), simulated anew. *As published* is the paper's processing,
*Kinopix* the analysis of `kinopix analyse` with its defaults. `kinopix reproduce all --docs docs/results` writes these pages.

"""
    return f"{text}{lines}\n"


def claims_table(result: Result) -> Table:
    """Give what the paper says, and whether our figures hold it."""
    table = Table(title="What the paper says", title_justify="left", show_header=False)
    table.add_column()
    table.add_column()
    for claim in result.study.claims(result.summary):
        table.add_row(plain(_verdict(claim.holds), "green" if claim.holds else "red"), plain(claim.text))
    return table


def write_csv(result: Result, folder: Path) -> list[Path]:
    """Write the figures over all seeds, and those of each seed, with every digit."""
    study, summary = result.study, result.summary
    over_all, of_each = folder / f"{study.name}.csv", folder / f"{study.name}-seeds.csv"
    with over_all.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["case", "x", "processing", "figure", "paper", "mean", "standard_deviation", "seeds"])
        for case in study.cases:
            for (label, processing, metric), spread in summary.spreads.items():
                if label == case.label:
                    printed = study.paper.get((label, metric), "")
                    x = "" if case.x is None else case.x
                    row = [label, x, processing, metric, printed, spread.mean, spread.deviation, spread.count]
                    writer.writerow(row)
    with of_each.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["case", "seed", "processing", "figure", "value"])
        for (label, seed), of_point in result.outcomes.items():
            for processing, outcome in of_point.items():
                writer.writerows([label, seed, processing, name, value] for name, value in outcome.figures.items())
    return [over_all, of_each]


def _cells(summary: Summary, metric: str) -> tuple[list[str], list[list[str]]]:
    """Give the heads of the columns, and each row's text; rows without any figure of this kind are left out."""
    study, digits = summary.study, METRICS[metric].digits
    printed = any(of == metric for _, of in study.paper)
    head = [*([_PAPER] if printed else []), *study.processings]
    rows: list[list[str]] = []
    for case in study.cases:
        spreads = [summary.spreads.get((case.label, processing, metric)) for processing in study.processings]
        if not any(spreads):
            continue
        row = [case.label]
        if printed:
            paper = study.paper.get((case.label, metric), math.nan)
            row.append("-" if math.isnan(paper) else f"{paper:.{digits}f}")
        rows.append([*row, *(_cell(spread, digits) for spread in spreads)])
    return head, rows


def _cell(spread: Spread | None, digits: int) -> str:
    if spread is None:
        return "-"
    return (
        f"{spread.mean:.{digits}f} ± {spread.deviation:.{digits}f}" if spread.count > 1 else f"{spread.mean:.{digits}f}"
    )


def _verdict(holds: bool) -> str:  # noqa: FBT001 - the only thing it is asked
    return "holds" if holds else "does not hold"
