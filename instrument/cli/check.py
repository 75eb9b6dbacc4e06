"""``kinopix check``: whether a recording is what was measured, or whether a bench can carry out a plan."""

from pathlib import Path
from typing import Annotated

import typer

from instrument.cli.libraries import tell_libraries
from instrument.cli.options import JsonOption, print_json


def check(
    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE]", help="Recording (.h5) to verify; without --bench and --plan.")
    ] = None,
    bench: Annotated[
        Path | None, typer.Option("--bench", help="bench.toml of the bench that is to carry out a plan.")
    ] = None,
    plan: Annotated[Path | None, typer.Option("--plan", help="plan.toml: the plan to check, with --bench.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Check a recording (kinopix check run.h5), or a plan before its run (kinopix check --bench ... --plan ...).

    A recording is held against its checksums, its raw counts and its plan: 0 where all is well, 3 where it is sound but
    not whole, 2 where it cannot be trusted. A plan is held against the bench: timing, memory, count rate, travel; 2 where
    it cannot be carried out. Nothing moves, nothing is shown, nothing is changed.
    """
    from instrument.plan import Plan
    from instrument.session import Instrument, check_recording
    from instrument.views import OUT, check_table
    from protocols import InputError

    if file is not None and bench is None and plan is None:
        report, code = check_recording(file)
    elif file is None and bench is not None and plan is not None:
        tell_libraries(bench)
        with Instrument.from_toml(bench) as instrument:
            report = instrument.check(Plan.from_toml(plan))
        code = 0 if report.ok else 2
    else:
        given = {"a recording": file, "--bench": bench, "--plan": plan}
        raise InputError(
            saw=" and ".join(name for name, value in given.items() if value is not None) or "nothing to check",
            expected="a recording alone, or --bench and --plan together",
            remedy="give kinopix check run.h5, or kinopix check --bench bench.toml --plan plan.toml",
        )
    if as_json:
        rows = [{"name": c.name, "outcome": c.outcome, "message": c.message} for c in report.checks]
        print_json({"ok": report.ok, "checks": rows})
    else:
        OUT.print(check_table(report))
    if code:
        raise typer.Exit(code)
