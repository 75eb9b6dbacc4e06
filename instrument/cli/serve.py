"""``kinopix serve``: a page in the browser on the bench at rest, and on past recordings."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from instrument.cli.options import JsonOption, print_json
from instrument.cli.pages import PORT, ControlOption, HostOption, PageOptions, PortOption, TokenOption, say_where

if TYPE_CHECKING:
    from instrument.web import RunPage


def serve(
    folder: Annotated[Path, typer.Argument(help="Folder with recordings; new ones go there too.")] = Path(),
    bench: Annotated[
        Path | None, typer.Option("--bench", help="bench.toml of a bench to hold open; without it recordings alone.")
    ] = None,
    plan: Annotated[
        Path | None, typer.Option("--plan", help="plan.toml: what the page checks, and starts with --control.")
    ] = None,
    host: HostOption = "127.0.0.1",
    port: PortOption = PORT,
    token: TokenOption = None,
    control: ControlOption = False,
    as_json: JsonOption = False,
) -> None:
    """Serve a page until Ctrl-C: who the devices are, what the plan's checks say, and past runs with their pictures.

    With --control the page can check, start, stop and home, in that the command does it: the server owns no device.
    """
    from instrument.web import Board, Desk, RunPage

    _refuse(bench, plan, control=control)
    options = PageOptions(host, port, token, control)
    page = RunPage(Board(str(bench or folder), control=control), Desk())
    with options.server(page.board, page.desk, folder) as server:
        say_where(server)
        if as_json:
            print_json({"page": server.address})
        if bench is None:
            while True:
                page.desk.take(0.2)  # Windows lets no Ctrl-C through while it waits
        _hold(bench, plan, folder, page, as_json=as_json)


def _hold(bench: Path, plan: Path | None, folder: Path, page: "RunPage", *, as_json: bool) -> None:
    """Hold the bench open, and do what pages wish."""
    from instrument.cli.libraries import tell_libraries
    from instrument.plan import Plan
    from instrument.session import Instrument
    from instrument.views import ERR, plain, say
    from instrument.web import serve_bench

    def tell(message: str) -> None:
        ERR.print(plain(message), soft_wrap=True)

    planned = None if plan is None else Plan.from_toml(plan)
    tell_libraries(bench)
    with Instrument.from_toml(bench) as instrument:
        serve_bench(instrument, planned, folder, page, tell if as_json else say)


def _refuse(bench: Path | None, plan: Path | None, *, control: bool) -> None:
    from protocols import InputError

    if bench is None and (plan is not None or control):
        raise InputError(
            saw="--plan or --control without a bench",
            expected="--bench bench.toml with them",
            remedy="name the bench, or leave both out to show recordings alone",
        )
