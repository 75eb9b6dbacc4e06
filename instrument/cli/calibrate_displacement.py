"""``kinopix calibrate displacement``: pixels a millimetre, and the stage's axis in the image."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from instrument.cli.calibrate import CalibrationOption, say_written, target
from instrument.cli.calibrate_runs import RunsOptions, measured_by, runs_in
from instrument.cli.options import (
    BenchOption,
    JsonOption,
    OverwriteOption,
    PathMapOption,
    SchedulerOption,
    TableOption,
    WorkersOption,
    print_json,
    refuse_no_amount,
)
from instrument.cli.several import refuse_failures

if TYPE_CHECKING:
    from instrument.config import BenchConfig, DisplacementSection
    from instrument.session import Instrument


def displacement(
    bench: BenchOption,
    positions_mm: Annotated[
        str | None, typer.Option(help="Positions of the stage, three or more: 0,2.5,5,7.5,10.", metavar="MM,MM,MM,...")
    ] = None,
    span_mm: Annotated[
        tuple[float, float] | None, typer.Option(help="First and last position, with --count between them.")
    ] = None,
    count: Annotated[int, typer.Option(min=3, max=200, help="Number of positions in --span-mm.")] = 5,
    one_way: Annotated[
        bool, typer.Option("--one-way", help="Visit each position on the way up only: half the time, no backlash.")
    ] = False,
    image_size: Annotated[int, typer.Option(help="Image pixels a side, as in the plans that it is to serve.")] = 128,
    superpixel: Annotated[int, typer.Option(help="Mirrors a side of a pixel, likewise.")] = 2,
    pattern_rate_hz: Annotated[float, typer.Option(help="Patterns a second of the static images.")] = 1000.0,
    frames: Annotated[
        int | None, typer.Option(min=1, help="Hadamard patterns, with their complements; 61 % of all if not given.")
    ] = None,
    from_runs: Annotated[
        list[Path] | None,
        typer.Option(
            "--from",
            help="Recording of a moving run, or folder of some: held against the stage's profile, nothing moves. May be given "
            "several times: their mean.",
        ),
    ] = None,
    recordings: Annotated[
        Path | None, typer.Option(help="New folder for the static images; beside the calibration file if not given.")
    ] = None,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    path_map: PathMapOption = None,
    table: TableOption = None,
    again: Annotated[bool, typer.Option("--again", help="With --from: measure those too that were measured.")] = False,
    out: CalibrationOption = None,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Measure pixels a millimetre and the stage's axis, and write them into the calibration file.

    Of several runs (--from) each is measured by itself, on all cores; one that fails is named, and the rest goes on. After Ctrl-C
    or a kill the same command does what is missing.

    The stage goes to each position, upwards and then downwards; at each, a static image is taken by conventional differential
    Hadamard patterns at a slow rate. The images are registered to a fraction of a pixel, and a line is fitted.
    """
    from instrument.config import load_bench, refuse_other, updated_calibration
    from instrument.session import Instrument
    from protocols import InputError

    refuse_no_amount(pattern_rate_hz=pattern_rate_hz)
    options = RunsOptions(workers, scheduler, path_map or (), table or (), again)
    if options.several and not from_runs:
        raise InputError(
            saw="--workers, --scheduler, --path-map, --table or --again without --from",
            expected="--from and recordings of moving runs",
            remedy="leave these out: the bench takes its static images one after the other",
        )
    runs = runs_in(from_runs, options) if from_runs else []
    config = load_bench(bench, calibrated=False)
    path = target(config, out)
    with Instrument.from_config(config) as opened:
        devices = opened.devices.identities()
        refuse_other(path, devices, config.magnification)  # before anything moves
        measured = None
        if not runs:
            measured = _measured(
                opened,
                _positions(positions_mm, span_mm, count),
                (image_size, superpixel, pattern_rate_hz, frames),
                recordings or _new_folder(path.parent),
                both_sides=not one_way,
                overwrite=overwrite,
            )
    by_runs = measured_by(runs, options, path) if len(runs) > 1 or options.several else None
    section = measured or (_of_run(runs[0]) if by_runs is None else by_runs.together)
    updated_calibration(path, "displacement", section, devices, config.magnification)
    _tell(config, section, path, as_json=as_json)
    if by_runs is not None:
        refuse_failures(by_runs.failures, len(runs), "measured")


def _positions(positions_mm: str | None, span_mm: tuple[float, float] | None, count: int) -> tuple[float, ...]:
    from protocols import InputError

    if (positions_mm is None) == (span_mm is None):
        raise InputError(
            saw="neither --positions-mm nor --span-mm" if positions_mm is None else "--positions-mm and --span-mm",
            expected="one of them, or --from and a recording",
            remedy="give --positions-mm 0,2.5,5 or --span-mm 0 5",
        )
    if span_mm is not None:
        first, last = span_mm
        return tuple(first + (last - first) * k / (count - 1) for k in range(count))
    try:
        return tuple(float(part) for part in (positions_mm or "").split(","))
    except ValueError as error:
        raise InputError(
            saw=f"--positions-mm {positions_mm}", expected="numbers with commas between them", remedy="give 0,2.5,5"
        ) from error


def _new_folder(beside: Path) -> Path:
    from datetime import UTC, datetime

    return beside / f"displacement-{datetime.now(UTC):%Y%m%d-%H%M%S}"


def _measured(
    opened: "Instrument",
    positions_mm: tuple[float, ...],
    image: tuple[int, int, float, int | None],
    folder: Path,
    *,
    both_sides: bool,
    overwrite: bool,
) -> "DisplacementSection":
    from instrument.calibration import Ladder, displacement_of, static_plan, take_views
    from instrument.views import ERR, plain, progress

    ladder = Ladder(positions_mm, both_sides=both_sides)
    plan = static_plan(*image)
    with progress() as bars:
        task = bars.add_task("static images", total=len(ladder.visits))
        visits = take_views(
            opened,
            ladder,
            plan,
            folder,
            overwrite=overwrite,
            on_visit=lambda done, total, what: bars.update(task, completed=done, total=total, description=what),
        )
        bars.update(task, completed=len(visits), description="static images")
    ERR.print(plain(f"kept {len(visits)} static images in {folder}"), soft_wrap=True)
    return displacement_of(visits)


def _of_run(path: Path) -> "DisplacementSection":
    from instrument.calibration import displacement_of_run
    from instrument.storage import open_recording

    return displacement_of_run(open_recording(path))


def _tell(config: "BenchConfig", section: "DisplacementSection", path: Path, *, as_json: bool) -> None:
    from instrument.views import OUT, displacement_figures, displacement_table

    if not as_json:
        OUT.print(displacement_table(section))
    say_written(config, path, as_json=as_json)
    if as_json:
        print_json({"calibration": str(path), **displacement_figures(section)})
