"""``kinopix calibrate alignment``: which way the image lies, and which way the stage goes in it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from instrument.cli.calibrate import CalibrationOption, say_written, target
from instrument.cli.calibrate_bench import ROLES, RateOption, RecordingsOption, opened, write
from instrument.cli.options import (
    BenchOption,
    ImageSizeOption,
    JsonOption,
    OverwriteOption,
    SuperpixelOption,
    print_json,
    refuse_no_amount,
)

if TYPE_CHECKING:
    from protocols import Floats


def alignment(
    bench: BenchOption,
    out: CalibrationOption = None,
    recordings: RecordingsOption = None,
    picture: Annotated[
        Path | None,
        typer.Option("--target", help="Picture of the target, upright, bright on dark; without it the letter F."),
    ] = None,
    step: Annotated[
        float | None,
        typer.Option("--step", help="Millimetres that the stage moves the target and back; without it none."),
    ] = None,
    frames: Annotated[int | None, typer.Option(help="Frames of each run; without it a quarter of the pixels.")] = None,
    pattern_rate_hz: RateOption = 20_000.0,
    image_size: ImageSizeOption = 128,
    superpixel: SuperpixelOption = 2,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Image a known target: in which of eight ways it lies, how patterns are wired, and which way the stage goes.

    Put the target upright into the light: the letter F, cut out of something dark, or one of your own with --target. With
    --step the stage carries it there and back. Look at the picture that is written: is its right half the target as you see it?
    """
    from instrument.calibration import calibrate_alignment
    from instrument.views import OUT, alignment_figure, figures_table, save, say, warn
    from protocols import InputError

    refuse_no_amount(pattern_rate_hz=pattern_rate_hz)
    if step is not None and not 0 < abs(step) < 1e6:
        raise InputError(saw=f"--step {step:g}", expected="millimetres, not 0", remedy="correct it, or leave it out")
    shape = None if picture is None else _target(picture)
    roles = ROLES if step is None else (*ROLES, "stage")
    with opened(bench, recordings, image_size, superpixel, overwrite, roles) as (config, instrument, field):
        found = calibrate_alignment(
            instrument, field, target=shape, step_mm=step, frames=frames, pattern_rate_hz=pattern_rate_hz
        )
        write(config, out, "alignment", found.section, instrument)
    drawn = save(alignment_figure(found), field.folder / "alignment.png")
    section = found.section
    if as_json:
        print_json({**section.model_dump(mode="json"), "verdict": list(found.verdict), "picture": str(drawn)})
        return
    rows = {
        "orientation": f"{section.orientation} (log-likelihood {section.certainty:.0f} over the next)",
        "turned by": f"{section.turn_deg} degrees more",
        "wiring": section.wiring,
        "target": f"{section.target_height_px:.1f} px high, {section.target_height_px * superpixel:.0f} mirrors",
    }
    if section.axis_angle_deg is not None and section.px_per_mm is not None:
        rows["positive travel"] = f"{section.axis_angle_deg} degrees from right towards down"
        rows["turned upright"] = f"{section.axis_angle_upright_deg:.1f} degrees"
        rows["scale"] = f"{section.px_per_mm} px/mm, {section.px_per_mm.value * superpixel:.1f} mirrors/mm"
    OUT.print(figures_table("Alignment", rows))
    say(found.verdict[0])
    for sentence in found.verdict[1:]:
        warn(f"- {sentence}")
    say(f"wrote {drawn}")
    say_written(config, target(config, out))


def _target(picture: Path) -> "Floats":
    """The target in a picture, cut to its border.

    Raises:
        InputError: no picture, or nothing bright in it.
    """
    import numpy as np

    from instrument.patterns import picture_of_file
    from protocols import InputError

    lit = picture_of_file(picture, 160).reshape(40, 4, 40, 4).mean(axis=(1, 3))
    rows, columns = np.flatnonzero((lit > 0.1).any(axis=1)), np.flatnonzero((lit > 0.1).any(axis=0))
    if not len(rows) or float(lit.min()) > 0.5:
        raise InputError(
            saw=f"{picture}, in which nothing is bright on dark",
            expected="a target that lets light through, on a dark ground",
            remedy="invert the picture, or take the letter F",
        )
    return np.asarray(lit[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1], np.float64)
