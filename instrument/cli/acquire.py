"""``kinopix run``.

What it stands on is loaded when it begins, and the live analysis, with its compiled loops, where it is asked for.
"""

import os
import sys
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from instrument.cli.about import NotesOption, SampleOption, TitleOption, UserOption, with_about
from instrument.cli.options import BenchOption, JsonOption, OverwriteOption, PlanOption, print_json
from instrument.cli.pages import PORT, ControlOption, HostOption, PageOptions, PortOption, TokenOption, say_where

if TYPE_CHECKING:
    from rich.progress import Progress

    from instrument.live import LiveAnalysis
    from instrument.plan import Plan
    from instrument.recording import Recording
    from instrument.session import Event, Listener
    from instrument.web import RunPage

POLISH_S: Final = 60.0
"""How long the live view may take for its last image when the run is over."""


def run(
    context: typer.Context,
    bench: BenchOption,
    plan: PlanOption,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Recording to write (.h5); run-<date>-<time>.h5 in this folder if not given."),
    ] = None,
    live: Annotated[
        bool, typer.Option("--live", help="Follow the object and show its image while the run goes on.")
    ] = False,
    light: Annotated[
        Path | None,
        typer.Option(
            help="Analysed recording by this bench: the live view takes what it says of leak, edge loss and offsets."
        ),
    ] = None,
    web: Annotated[
        bool, typer.Option("--web", help="Show the run on a page in the browser, as --live does in the terminal.")
    ] = False,
    host: HostOption = "127.0.0.1",
    port: PortOption = PORT,
    token: TokenOption = None,
    control: ControlOption = False,
    title: TitleOption = None,
    sample: SampleOption = None,
    user: UserOption = None,
    notes: NotesOption = None,
    log: Annotated[
        bool,
        typer.Option(
            "--log", help="Keep a log beside the recording, run.log beside run.h5; one that is there goes on."
        ),
    ] = False,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Acquire: move the stage, play the patterns, count the light, write the recording while it runs."""
    from instrument.cli.log import log_beside
    from instrument.plan import Plan
    from instrument.session import next_name
    from instrument.storage import hdf5_has_failed
    from instrument.views import OUT, say, show_error, timing_table, warn
    from protocols import KinopixError

    try:
        page = PageOptions(host, port, token, control) if web else None
        out = out or next_name(Path())
        if log:
            log_beside(out, context.obj)
        asked = with_about(Plan.from_toml(plan), title=title, sample=sample, user=user, notes=notes)
        recording = record(bench, asked, out, overwrite=overwrite, live=live, light=light, page=page)
    except (KinopixError, typer.Exit) as error:
        if not hdf5_has_failed():
            raise
        # All is told and the devices are safe. HDF5 may crash, or wait for ever, when it ends: it is not let end.
        if isinstance(error, KinopixError):
            show_error(error)
        sys.stderr.flush()
        os._exit(error.exit_code)
    if recording.timing is None:
        return
    if recording.timing.verdict == "failed":
        warn(f"the timing audit trusts no frame of this run; its raw counts are kept in {out}")
    if as_json:
        print_json({"recording": str(out), "timing": recording.timing.model_dump(mode="json")})
    else:
        OUT.print(timing_table(recording.timing))
        say(f"recorded {len(recording)} frames in {out}")
    if recording.timing.verdict == "failed":
        raise typer.Exit(3)


def record(
    bench: Path,
    plan: "Plan",
    out: Path,
    *,
    overwrite: bool,
    live: bool = False,
    light: Path | None = None,
    page: PageOptions | None = None,
) -> "Recording":
    """Run one plan with progress bars, with motion and image below them if ``live``, and on a page if there is one.

    Raises:
        KinopixError: as ``Instrument.run``; the page cannot be served.
        KeyboardInterrupt: after the bench was made safe; the notes say what is kept.
    """
    from instrument.session import Instrument
    from instrument.storage import remains_of
    from instrument.views import LOG, LiveView, log_events, progress, warn

    bars = progress()
    for left in remains_of(out):
        warn(f"{left} was left behind by a program that ended early; the run removes it")
    analysis = _live_analysis(plan, light) if live or page is not None else None
    with ExitStack() as stack:  # left from the end: the bench is safe before the page has gone
        shown = None if page is None else stack.enter_context(_page(page, str(bench), out))
        instrument = stack.enter_context(Instrument.from_toml(bench))
        drawn = stack.enter_context(LiveView(bars) if live else bars)
        listeners: list[Listener] = [_ProgressBars(bars, plan.patterns), *([log_events] if LOG.handlers else [])]
        if analysis is not None:
            listeners.append(analysis)
        if isinstance(drawn, LiveView):
            if "counter" in instrument.devices.by_role:
                drawn.hold_against(instrument.counter.limits.max_count_rate_hz * plan.picture_time_s)
            listeners.append(drawn)
        if shown is not None:
            listeners.append(shown.begins(instrument, plan))
        with instrument.start(plan, out, overwrite=overwrite, listeners=listeners) as run:
            if shown is not None:
                shown.attend(run)
            recording = run.wait()
            run.wait_for_listeners(POLISH_S)
    for failure in run.snapshot.listener_failures:
        warn(f"{failure.listener} ended early, the recording did not: {failure.error}")
    if analysis is not None and analysis.counters.frames_dropped:
        warn(f"{analysis.counters.frames_dropped} frames came too fast for the live view; the recording has them all")
    return recording


def _live_analysis(plan: "Plan", light: Path | None) -> "LiveAnalysis":
    from instrument.live import LiveAnalysis

    if light is None:
        return LiveAnalysis(plan)
    from instrument.analysis import light_found

    return LiveAnalysis(plan, light=light_found(light))


@contextmanager
def _page(options: PageOptions, title: str, out: Path) -> "Generator[RunPage]":
    """Serve the page of a run, and of the recordings beside it."""
    from instrument.web import Board, Desk, RunPage

    page = RunPage(Board(title, control=options.control), Desk())
    with options.server(page.board, page.desk, out.parent) as server:
        say_where(server)
        yield page


class _ProgressBars:
    """A listener that draws how far the run is."""

    name: Final = "the progress bars"

    def __init__(self, bars: "Progress", patterns: int) -> None:
        self._bars = bars
        self._upload = bars.add_task("patterns uploaded", total=None)
        self._counted = bars.add_task("patterns counted", total=patterns)

    def __call__(self, event: "Event") -> None:
        from instrument.session import BlockEvent, UploadEvent

        if isinstance(event, UploadEvent):
            self._bars.update(self._upload, completed=event.stored, total=event.total)
        elif isinstance(event, BlockEvent):
            self._bars.update(self._counted, completed=event.first_pattern + event.patterns)
