"""What a calibration of displacement says, for people and for programs."""

from typing import TYPE_CHECKING, Any

from rich.table import Table

from instrument.numerics import coverage_factor
from instrument.views.terminal import figures_table

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
