"""The table of a series of recordings in the terminal."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.table import Table

from instrument.views.terminal import coloured, plain

_COLUMNS = ("recording", "outcome", "frames", "travel px", "speed", "sigma px", "misfit", "PSNR", "doubts")


def series_table(rows: Sequence[Mapping[str, str | float | int | None]]) -> Table:
    """Give a table with a line for each recording.

    Args:
        rows: as ``instrument.series.rows_of`` gives them.
    """
    table = Table(title="Recordings", title_justify="left", box=None, padding=(0, 1, 0, 0))
    for name in _COLUMNS:
        table.add_column(name, justify="left" if name in {"recording", "outcome"} else "right")
    for row in rows:
        table.add_row(
            plain(Path(str(row["recording"])).name),
            coloured(str(row["outcome"])),
            *(plain(text) for text in _figures(row)),
        )
    return table


def _figures(row: Mapping[str, str | float | int | None]) -> list[str]:
    unit = "px" if row["speed_mm_s"] is None else "mm"
    doubts = str(row["doubts"] or "")
    travel = "" if row["travel_x_px"] is None else f"{row['travel_x_px']:.1f}, {row['travel_y_px']:.1f}"
    frames = "" if row["frames"] is None else f"{row['frames']}"
    return [
        frames,
        travel,
        _number(row[f"speed_{unit}_s"], ".4g", f" {unit}/s"),
        _number(row["sigma_px"], ".3f"),
        _number(row["misfit"], ".2f"),
        _number(row["psnr_db"], ".1f", " dB"),
        str(len(doubts.split(" | "))) if doubts else "",
    ]


def _number(value: str | float | None, digits: str, unit: str = "") -> str:
    return "" if value is None else f"{float(value):{digits}}{unit}"
