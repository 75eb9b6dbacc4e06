"""The command's frame: its sub-commands, and how it ends."""

import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Final

import typer
from typer.core import TyperGroup

from instrument.cli import (
    acquire,
    analyse,
    calibrate,
    calibrate_alignment,
    calibrate_bench,
    calibrate_displacement,
    check,
    compare,
    convert,
    count,
    demo,
    drivers,
    export,
    film,
    info,
    init,
    move,
    new_driver,
    probe,
    recover,
    reproduce,
    schema,
    serve,
    show,
)
from instrument.cli.interrupts import Interrupts

INTERRUPTED: Final = 130
"""Exit code after Ctrl-C, as a shell gives it: 128 and the signal's number."""

UNSAFE: Final = 3
"""Exit code of a fault of a device. It stands above an interrupt: that the bench could not be made safe must not be missed."""


@contextmanager
def _telling() -> Generator[None]:
    """Tell an interrupt before typer words it in its own way, or in none."""
    try:
        yield
    except KeyboardInterrupt as interrupt:
        raise typer.Exit(_told(interrupt)) from None


class _Group(TyperGroup):
    """The sub-commands, which tell of an interrupt."""

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Read the arguments."""
        with _telling():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: Any) -> Any:
        """Run the sub-command."""
        with _telling():
            return super().invoke(ctx)


app = typer.Typer(
    cls=_Group,
    help="Single-pixel imaging of moving objects: run the bench, follow the object, see it sharp.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)
app.command("demo")(demo.demo)
app.command("run")(acquire.run)
app.command("analyse")(analyse.analyse_file)
app.command("check")(check.check)
app.command("compare")(compare.compare_files)
app.command("convert")(convert.convert)
app.command("export")(export.export)
app.command("film")(film.film)
app.command("info")(info.info)
app.command("recover")(recover.recover_file)
app.command("init")(init.init)
app.command("new-driver")(new_driver.new_driver)
app.command("reproduce")(reproduce.reproduce_paper)
app.command("schema")(schema.schema)
app.command("serve")(serve.serve)
app.command("show")(show.show)
app.command("count")(count.count)
app.command("move", context_settings={"ignore_unknown_options": True})(move.move)
app.command("probe")(probe.probe)
calibrate.app.command("detector")(calibrate_bench.detector)
calibrate.app.command("mirrors")(calibrate_bench.mirrors)
calibrate.app.command("light")(calibrate_bench.light)
calibrate.app.command("alignment")(calibrate_alignment.alignment)
calibrate.app.command("displacement")(calibrate_displacement.displacement)
app.add_typer(calibrate.app, name="calibrate")
app.add_typer(drivers.app, name="drivers")


def _print_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"kinopix {version('kinopix')}")
        raise typer.Exit


@app.callback()
def root(
    context: typer.Context,
    _version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and end.")
    ] = False,
    log: Annotated[
        Path | None,
        typer.Option("--log", help="File to append a log to: what is asked, said and found, with the time of each."),
    ] = None,
    verbose: Annotated[
        bool, typer.Option("--verbose", help="Log every block and image too; without --log to standard error.")
    ] = False,
) -> None:
    """Single-pixel imaging of moving objects: run the bench, follow the object, see it sharp."""
    if log is not None or verbose:
        from instrument.cli.log import begin_log

        begin_log(log, context.obj, verbose=verbose)


def main(arguments: list[str] | None = None) -> None:
    """Run the command and end the process: 0 good, 2 wrong input, 3 device or timing fault, 130 interrupted.

    Being ended by another program (143), or by a terminal that is closed (129), is as Ctrl-C: the bench is made safe first.
    """
    interrupts = Interrupts()
    try:
        interrupts.listen()
        code = status(arguments, interrupts)
    except KeyboardInterrupt as interrupt:  # it came before the sub-command, or after
        code = _told(interrupt)
    interrupts.over = True
    # Python notes an interrupt that leaves the text of an exec, as dataclasses run one, and in the end kills itself by SIGINT
    # for it, whatever the exit code, though the interrupt was met. The next such text that ends well takes the note back.
    exec("")  # noqa: S102 - of nothing
    sys.exit(code if code == UNSAFE else interrupts.exit_code(code))


def _told(error: BaseException) -> int:
    """Say in one paragraph that the command was interrupted, and what was kept; give the exit code."""
    print("; ".join(["kinopix: interrupted", *getattr(error, "__notes__", ())]), file=sys.stderr)  # noqa: T201 - rich may be what broke
    return INTERRUPTED


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


def status(arguments: list[str] | None = None, interrupts: Interrupts | None = None) -> int:
    """Run the command and give its exit code.

    Args:
        arguments: of the command; None takes those of the process.
        interrupts: heard meanwhile. After one of them every error but ``SafeStateFailed`` is taken for its consequence: a library
            that is interrupted in its midst words that in its own way.
    """
    _forget_warnings()
    code = None
    try:
        code = _status(sys.argv[1:] if arguments is None else arguments, interrupts)
        return code
    finally:
        _end_log(code)


def _forget_warnings() -> None:
    """Begin without warnings, where what keeps them has been loaded at all."""
    terminal = sys.modules.get("instrument.views.terminal")
    if terminal is not None:
        terminal.forget_warnings()


def _end_log(code: int | None) -> None:
    """End the log, if there is one, with how the command ended."""
    log = sys.modules.get("instrument.cli.log")
    if log is not None:
        log.end_log(code)


def _status(arguments: list[str], interrupts: Interrupts | None) -> int:
    try:
        _refuse_bytes(arguments)
        app(arguments, obj=arguments)  # for the log
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except Exception as error:
        from instrument.cli.failure import exit_code_of, is_unsafe

        if interrupts is not None and interrupts.number is not None and not is_unsafe(error):
            return _told(error)
        code = exit_code_of(error)
        if code is None:
            raise
        return code
    return 0
