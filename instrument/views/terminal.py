"""Tables, messages and progress bars in the terminal."""

import logging
import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Final

from rich.console import Console
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:  # these are named in signatures only, so that a table loads no numpy
    from rich.progress import Progress

    from instrument.acquisition import CheckReport
    from instrument.recording import TimingReport
    from protocols import KinopixError

OUT: Final = Console(highlight=False, emoji=False)
"""Standard output, for figures and tables."""

ERR: Final = Console(stderr=True, highlight=False, emoji=False)
"""Standard error, for progress, warnings and errors, so that the output of ``--json`` holds nothing else."""

LOG: Final = logging.getLogger("kinopix")
"""What is said is logged too; ``--log`` keeps it."""
LOG.addHandler(logging.NullHandler())  # without --log Python would print warnings a second time

_WARNED: list[str] = []

_LISTED = 8
_COLOURS = {
    "good": "green",
    "warning": "yellow",
    "flagged": "yellow",
    "partial": "yellow",
    "error": "red",
    "failed": "red",
}

_STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Characters that move a terminal's cursor, turn its writing round, or are none at all."""


def plain(text: str, style: str = "") -> Text:
    r"""Give a text to be printed as it stands: brackets are no markup, and what would steer the terminal is written out.

    Names of files, plans and plug-ins come from anywhere: ``a[bold].h5`` is printed so, and an escape as ``\x1b``.
    """
    return Text(_STEERING.sub(lambda found: ascii(found[0])[1:-1], text), style=style)


def say(message: str) -> None:
    """Print one line to standard output, as it stands."""
    _log(logging.INFO, message)
    OUT.print(plain(message), soft_wrap=True)


def progress() -> "Progress":
    """Give a progress bar with count, elapsed and remaining time. It removes itself, and nothing else, at its end."""
    from rich.progress import (  # noqa: PLC0415 - a table loads none of them
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=ERR,
        transient=True,
    )


def figures_table(title: str, figures: Mapping[str, str | Text]) -> Table:
    """Give a table of two columns, name and value."""
    table = Table(title=plain(title), title_justify="left", show_header=False)
    table.add_column(style="bold")
    table.add_column()
    for name, value in figures.items():
        table.add_row(plain(name), plain(value) if isinstance(value, str) else value)
    return table


def check_table(report: "CheckReport") -> Table:
    """Give the table of a check report, with one row for each check."""
    table = Table(title="Checks", title_justify="left")
    for column in ("what", "outcome", "figures"):
        table.add_column(column)
    for check in report.checks:
        table.add_row(plain(check.name), coloured(check.outcome), plain(check.message))
    return table


def timing_table(report: "TimingReport") -> Table:
    """Give the table of a timing report."""
    rows: dict[str, str | Text] = {
        "verdict": coloured(report.verdict),
        "patterns": f"{report.patterns_recorded} of {report.patterns_expected}, {report.bins_received} bins",
        "frames": f"{report.frames}, {report.frames_masked} masked",
        "picture time": f"{report.picture_time_s * 1e6:g} us",
    }
    if report.mean_period_s is not None and report.jitter_s is not None:
        offset_ppm = report.clock_offset_ppm or 0.0
        rows["sync period"] = f"{report.mean_period_s * 1e6:.4f} us ({offset_ppm:+.1f} ppm)"
        rows["jitter"] = f"{report.jitter_s * 1e9:.1f} ns, at most {(report.largest_deviation_s or 0) * 1e9:.1f} ns"
    if report.edges_seen is not None:
        rows["sync edges"] = f"{report.edges_seen} seen, {report.surplus_edges} after the run"
    for name, found in (("gaps", report.gaps), ("doubles", report.doubles), ("irregular", report.irregular)):
        if found:
            rows[name] = f"{len(found)}, at pattern {_listed(found)}"
    if report.brightest_rate_hz is not None:
        rows["brightest"] = f"{report.brightest_rate_hz:.3g} counts/s"
    for k, note in enumerate(report.notes):
        rows[f"note {k + 1}"] = note
    return figures_table("Timing audit", rows)


def show_error(error: "KinopixError") -> None:
    """Print one clear paragraph to standard error."""
    _log(logging.ERROR, "; ".join([str(error), *getattr(error, "__notes__", ())]))
    ERR.print(Text.assemble(("kinopix:", "bold red"), " ", plain(str(error))), soft_wrap=True)
    for note in getattr(error, "__notes__", ()):
        ERR.print(plain(note), soft_wrap=True)


def warn(message: str) -> None:
    """Print one line to standard error, and keep it for ``warned``."""
    _log(logging.WARNING, message)
    _WARNED.append(message)
    ERR.print(plain(message, "yellow"), soft_wrap=True)


def warned() -> tuple[str, ...]:
    """Give what was warned of since ``forget_warnings``, for ``--json``."""
    return tuple(_WARNED)


def forget_warnings() -> None:
    """Begin a command in which nothing has been warned of."""
    _WARNED.clear()


def _log(level: int, message: str) -> None:
    """Log what is printed, where anybody keeps a log: without one, Python itself prints warnings a second time."""
    if LOG.hasHandlers():
        LOG.log(level, "%s", message)


def coloured(outcome: str) -> Text:
    """Give the word in its colour."""
    return plain(outcome, _COLOURS.get(outcome, "white"))


def _listed(indices: Iterable[int]) -> str:
    """Write out the first eight indices."""
    shown = [str(k) for k in indices]
    return ", ".join(shown[:_LISTED]) + (", ..." if len(shown) > _LISTED else "")
