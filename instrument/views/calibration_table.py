"""What a calibration of displacement says, for people and for programs."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.table import Table

from instrument.numerics import coverage_factor
from instrument.views.terminal import coloured, figures_table, plain

if TYPE_CHECKING:
    from instrument.config import DisplacementSection


def displacement_figures(section: "DisplacementSection") -> dict[str, Any]:
    """Give the section with what follows from it, as ``--json`` prints it."""
    reach = coverage_factor(section.degrees_of_freedom)
    scale, angle = section.px_per_mm, section.axis_angle_deg
    of_scale, of_angle = reach * section.px_per_mm_sigma, reach * section.axis_angle_sigma_deg
    return {
        "px_per_mm": scale,
        "px_per_mm_sigma": section.px_per_mm_sigma,
        "px_per_mm_95": [scale - of_scale, scale + of_scale],
        "axis_angle_deg": angle,
        "axis_angle_sigma_deg": section.axis_angle_sigma_deg,
        "axis_angle_95_deg": [angle - of_angle, angle + of_angle],
        "displacement": section.model_dump(mode="json"),
    }


def displacement_rows(section: "DisplacementSection") -> dict[str, str]:
    """Give the numbers as a person reads them: text by name."""
    reach = coverage_factor(section.degrees_of_freedom)
    of_scale, of_angle = reach * section.px_per_mm_sigma, reach * section.axis_angle_sigma_deg
    rows = {
        "scale": f"{section.px_per_mm:.4f} +- {of_scale:.4f} px/mm ({100 * of_scale / section.px_per_mm:.2f} %, 95 %)",
        "a pixel": f"{1e3 / section.px_per_mm:.3f} um",
        "axis": f"{section.axis_angle_deg:.3f} +- {of_angle:.3f} degrees from x towards y (95 %)",
        "along x, y": f"{section.px_per_mm_x:.4f}, {section.px_per_mm_y:.4f} px/mm",
    }
    if section.backlash_mm is not None and section.backlash_sigma_mm is not None:
        rows["backlash"] = f"{1e3 * section.backlash_mm:.1f} +- {1e3 * reach * section.backlash_sigma_mm:.1f} um (95 %)"
    if section.rms_residual_px is not None:
        rows["residuals"] = f"{section.rms_residual_px:.4f} px rms"
    rows["holds for"] = f"{section.image_size} px of {section.superpixel} x {section.superpixel} mirrors"
    return rows


def displacement_table(section: "DisplacementSection") -> Table:
    """Give the numbers as a table."""
    return figures_table(f"Displacement, by {section.method}", displacement_rows(section))


def runs_table(rows: Sequence[Mapping[str, str | float | int | None]]) -> Table:
    """Give a table with a line for each run of which a displacement was measured.

    Args:
        rows: with ``recording``, ``outcome``, and scale and axis with their standard uncertainties, None where there is none.
    """
    table = Table(title="Runs", title_justify="left", box=None, padding=(0, 1, 0, 0))
    for name in ("recording", "outcome", "px/mm", "axis, degrees"):
        table.add_column(name, justify="left" if name in {"recording", "outcome"} else "right")
    for row in rows:
        found = row["px_per_mm"] is not None
        scale = f"{row['px_per_mm']:.4f} +- {row['px_per_mm_sigma']:.4f}" if found else ""
        axis = f"{row['axis_angle_deg']:.3f} +- {row['axis_angle_sigma_deg']:.3f}" if found else ""
        table.add_row(plain(Path(str(row["recording"])).name), coloured(str(row["outcome"])), plain(scale), plain(axis))
    return table
