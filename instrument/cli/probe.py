"""``kinopix probe``: every device of the bench, one after the other; with ``--commission`` measured, for a report."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from instrument.cli.options import BenchOption, JsonOption, OverwriteOption, print_json, refuse_taken

if TYPE_CHECKING:
    from instrument.commissioning import Consent


def probe(
    bench: BenchOption,
    commission: Annotated[
        bool,
        typer.Option(
            "--commission", help="Measure each device too, and write a report. Asks before it shows or moves anything."
        ),
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="Report of --commission, without ending: .txt and .json are written.")
    ] = None,
    only: Annotated[
        str | None, typer.Option(help="The only device to commission: modulator, counter or stage.")
    ] = None,
    yes: Annotated[
        bool,
        typer.Option("--yes", help="Agree to pictures, motion and homing: the way is free, somebody is at the switch."),
    ] = False,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Open each device of the bench alone, and tell who it is, what it can do, and what is doubtful.

    Nothing moves or is shown, but with --commission, which asks first: it answers the bench questions of each driver's how-to
    as far as a program can, brings the stage back to where it stood, and writes a report that can be sent back.

    Exits with 3 if a device does not open; the others are told all the same.
    """
    if commission:
        _commission(bench, out, only, yes=yes, overwrite=overwrite, as_json=as_json)
    else:
        _refuse_alone(out, only, yes=yes, overwrite=overwrite)
        _probe(bench, as_json=as_json)


def _probe(bench: Path, *, as_json: bool) -> None:
    from instrument.cli.libraries import tell_libraries
    from instrument.session import probe_bench
    from instrument.views import OUT, figures_table, show_error, warn

    tell_libraries(bench, ())
    found = probe_bench(bench)
    if as_json:
        print_json({"devices": {device.role: device.as_dict() for device in found}})
    else:
        for device in found:
            if device.figures:
                OUT.print(figures_table(device.role, device.figures))
            for doubt in device.doubts:
                warn(f"{device.role}: {doubt}")
            if device.error is not None:
                show_error(device.error)
    if any(device.error is not None for device in found):
        raise typer.Exit(max(device.error.exit_code for device in found if device.error is not None))


def _commission(bench: Path, out: Path | None, only: str | None, *, yes: bool, overwrite: bool, as_json: bool) -> None:
    from datetime import UTC, datetime

    from instrument.cli.libraries import tell_libraries
    from instrument.commissioning import commission
    from instrument.roles import ROLES
    from instrument.views import ERR, plain
    from protocols import InputError

    roles = [role.name for role in ROLES]
    if only is not None and only not in roles:
        raise InputError(saw=f"--only {only}", expected=" or ".join(roles), remedy="correct it")
    stem = out or Path(f"commissioning-{datetime.now(UTC):%Y%m%d-%H%M%S}")
    for ending in ("txt", "json"):
        refuse_taken(stem.with_name(f"{stem.name}.{ending}"), overwrite=overwrite)
    tell_libraries(bench, ())
    report = commission(bench, _consent(yes=yes), only=only, tell=lambda text: ERR.print(plain(text, "dim")))
    written = report.write(stem)
    if as_json:
        print_json(report.model_dump(mode="json"))
    else:
        typer.echo(report.text())
    ERR.print(plain(f"written: {written[0]} and {written[1]}; fill in what is left, and send both"), soft_wrap=True)
    if report.failed:
        raise typer.Exit(3)


def _consent(*, yes: bool) -> "Consent":
    """Ask the person at the terminal; where nobody can answer, nothing is shown and nothing moves."""

    def agreed(_effect: str, what: str) -> bool:
        if yes:
            return True
        if not sys.stdin.isatty():
            return False
        return typer.confirm(what, default=False, err=True)

    return agreed


def _refuse_alone(out: Path | None, only: str | None, *, yes: bool, overwrite: bool) -> None:
    from protocols import InputError

    given = {"--out": out is not None, "--only": only is not None, "--yes": yes, "--overwrite": overwrite}
    wrong = [name for name, is_given in given.items() if is_given]
    if wrong:
        raise InputError(
            saw=f"{', '.join(wrong)} without --commission", expected="both, or neither", remedy="add --commission"
        )
