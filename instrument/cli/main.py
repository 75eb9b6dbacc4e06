"""The command's frame: its sub-commands, and how it ends."""

import signal
import sys
from typing import Annotated

import typer

from instrument.cli import acquire, analyse, check, demo, drivers, info, recover

app = typer.Typer(
    help="Single-pixel imaging of moving objects: run the bench, follow the object, see it sharp.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)
app.command("demo")(demo.demo)
app.command("run")(acquire.run)
app.command("analyse")(analyse.analyse_file)
app.command("check")(check.check)
app.command("info")(info.info)
app.command("recover")(recover.recover_file)
app.add_typer(drivers.app, name="drivers")


def _print_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"kinopix {version('kinopix')}")
        raise typer.Exit


@app.callback()
def root(
    _version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and end.")
    ] = False,
) -> None:
    """Single-pixel imaging of moving objects: run the bench, follow the object, see it sharp."""


def main(arguments: list[str] | None = None) -> None:
    """Run the command and end the process: 0 good, 2 wrong input, 3 device or timing fault, 130 interrupted.

    Being ended by another program, or by a terminal that is closed, is as Ctrl-C: the bench is made safe first.
    """
    for name in ("SIGTERM", "SIGHUP"):  # Windows has no SIGHUP
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.default_int_handler)
    sys.exit(status(arguments))


def _refuse_bytes(arguments: list[str]) -> None:
    """Refuse names that are no text: a recording keeps names as UTF-8, and would fail when it is begun."""
    for argument in arguments:
        if not argument.isascii() and argument != argument.encode(errors="replace").decode():
            from protocols import InputError

            raise InputError(
                saw=f"the argument {argument!a}, which has bytes that are no text",
                expected="names in UTF-8",
                remedy="rename the file or folder",
            )


def status(arguments: list[str] | None = None) -> int:
    """Run the command and give its exit code."""
    try:
        _refuse_bytes(sys.argv[1:] if arguments is None else arguments)
        app(arguments)
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except Exception as error:
        from instrument.cli.failure import exit_code_of

        code = exit_code_of(error)
        if code is None:
            raise
        return code
    return 0
