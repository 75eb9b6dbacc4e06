"""``kinopix run``.

What they stand on is loaded when they begin, and the live analysis, with its compiled loops, where it is asked for.
"""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from instrument.cli.options import BenchOption, JsonOption, OverwriteOption, PlanOption, print_json

if TYPE_CHECKING:
    from rich.progress import Progress

    from instrument.plan import Plan
    from instrument.recording import Recording
    from instrument.session import Event, Listener

POLISH_S: Final = 60.0
"""How long the live view may take for its last image when the run is over."""


def run(
    bench: BenchOption,
    plan: PlanOption,
    out: Annotated[Path, typer.Option("--out", help="Recording to write (.h5).")],
    live: Annotated[
        bool, typer.Option("--live", help="Follow the object and show its image while the run goes on.")
    ] = False,
    light: Annotated[
        Path | None,
        typer.Option(
            help="Analysed recording by this bench: the live view takes what it says of leak, edge loss and offsets."
        ),
    ] = None,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Acquire: move the stage, play the patterns, count the light, write the recording while it runs."""
    from instrument.plan import Plan
    from instrument.storage import hdf5_has_failed
    from instrument.views import OUT, say, show_error, timing_table, warn
    from protocols import KinopixError

    try:
        recording = record(bench, Plan.from_toml(plan), out, overwrite=overwrite, live=live, light=light)
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
    if as_json:
        print_json({"recording": str(out), "timing": recording.timing.model_dump(mode="json")})
    else:
        OUT.print(timing_table(recording.timing))
        say(f"recorded {len(recording)} frames in {out}")
    if recording.timing.verdict == "failed":
        warn(f"the timing audit trusts no frame of this run; its raw counts are kept in {out}")
        raise typer.Exit(3)


def record(
    bench: Path, plan: "Plan", out: Path, *, overwrite: bool, live: bool = False, light: Path | None = None
) -> "Recording":
    """Run one plan with progress bars, and with motion and image below them if ``live``.

    Raises:
        KinopixError: as ``Instrument.run``.
        KeyboardInterrupt: after the bench was made safe; the notes say what is kept.
    """
    from instrument.session import Instrument
    from instrument.storage import remains_of
    from instrument.views import LiveView, progress, warn

    bars = progress()
    for left in remains_of(out):
        warn(f"{left} was left behind by a program that ended early; the run removes it")
    analysis = None
    if live:
        from instrument.live import LiveAnalysis

        if light is None:
            analysis = LiveAnalysis(plan)
        else:
            from instrument.analysis import light_found

            analysis = LiveAnalysis(plan, light=light_found(light))
    with Instrument.from_toml(bench) as instrument, LiveView(bars) if live else bars as shown:
        listeners: list[Listener] = [_ProgressBars(bars, plan.patterns)]
        if analysis is not None and isinstance(shown, LiveView):
            listeners += [analysis, shown]
        with instrument.start(plan, out, overwrite=overwrite, listeners=listeners) as run:
            recording = run.wait()
            run.wait_for_listeners(POLISH_S)
    for failure in run.snapshot.listener_failures:
        warn(f"{failure.listener} ended early, the recording did not: {failure.error}")
    if analysis is not None and analysis.counters.frames_dropped:
        warn(f"{analysis.counters.frames_dropped} frames came too fast for the live view; the recording has them all")
    return recording


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
