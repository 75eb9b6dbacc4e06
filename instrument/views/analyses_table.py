"""Several analyses in one table."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.table import Table

from instrument.views.terminal import plain

if TYPE_CHECKING:
    from instrument.analysis import Figures
    from instrument.tracking import Quantity


def analyses_table(analyses: "Sequence[tuple[Path, Figures]]") -> Table:
    """Give a line for each recording: how far its object went, how well that is known, how good the image is, what is doubtful.

    Columns that no recording fills are left out.
    """
    columns = {
        "frames": [f"{f.frames}" + (f", {f.frames_masked} masked" if f.frames_masked else "") for _, f in analyses],
        "travel, px": [
            "" if f.travel_px is None else f"{f.travel_px[0]:.2f}, {f.travel_px[1]:.2f}" for _, f in analyses
        ],
        "sigma, px": ["" if f.sigma_px is None else f"{f.sigma_px:.3f}" for _, f in analyses],
        "speed, mm/s (95 %)": ["" if f.motion_mm is None else _interval(f.motion_mm.speed) for _, f in analyses],
        "MSE, px^2": ["" if f.displacement_mse_px2 is None else f"{f.displacement_mse_px2:.4f}" for _, f in analyses],
        "PSNR, dB": ["" if f.psnr_db is None else f"{f.psnr_db:.1f}" for _, f in analyses],
        "misfit": ["" if f.misfit is None else f"{f.misfit:.3f}" for _, f in analyses],
        "doubts": [str(len(f.doubts)) if f.doubts else "" for _, f in analyses],
    }
    filled = {name: cells for name, cells in columns.items() if any(cells)}
    table = Table(title="Analyses", title_justify="left")
    table.add_column("recording", overflow="fold")
    for name in filled:
        table.add_column(name, justify="right")
    for row, (file, _) in enumerate(analyses):
        table.add_row(plain(file.name), *(plain(cells[row]) for cells in filled.values()))
    return table


def _interval(number: "Quantity") -> str:
    return f"{number.value:.3f} +- {(number.high - number.low) / 2:.3f}"
