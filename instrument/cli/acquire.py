"""``kinopix run`` and ``kinopix check``."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, TypeAlias

import typer
from rich.progress import Progress

from instrument.acquisition import AlignedBlock
from instrument.cli.options import BenchOption, JsonOption, OverwriteOption, PlanOption, print_json
from instrument.instrument import Instrument
from instrument.live import LiveAnalysis
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.views import OUT, LiveView, check_table, progress, timing_table, warn

OnBlock: TypeAlias = Callable[[AlignedBlock], None]


def run(
    bench: BenchOption,
    plan: PlanOption,
    out: Annotated[Path, typer.Option("--out", help="Recording to write (.h5).")],
    live: Annotated[
        bool, typer.Option("--live", help="Follow the object and show its image while the run goes on.")
    ] = False,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Acquire: move the stage, play the patterns, count the light, write the recording while it runs."""
    recording = record(bench, Plan.from_toml(plan), out, overwrite=overwrite, live=live)
    if recording.timing is None:
        return
    if as_json:
        print_json({"recording": str(out), "timing": recording.timing.model_dump(mode="json")})
    else:
        OUT.print(timing_table(recording.timing))
        OUT.print(f"recorded {len(recording)} frames in {out}", soft_wrap=True)
    if recording.timing.verdict == "failed":
        warn(f"the timing audit trusts no frame of this run; its raw counts are kept in {out}")
        raise typer.Exit(3)


def record(bench: Path, plan: Plan, out: Path, *, overwrite: bool, live: bool = False) -> Recording:
    """Run one plan with progress bars, and with motion and image below them if ``live``.

    Raises:
        KinopixError: as ``Instrument.run``; Ctrl-C ends the command with 130 after the bench was made safe.
    """
    bars = progress()
    with Instrument.from_toml(bench) as instrument, _looked_at(plan, bars) if live else _bars_alone(bars) as look:
        upload = bars.add_task("patterns uploaded", total=None)
        patterns = bars.add_task("patterns counted", total=plan.patterns)

        def on_upload(done: int, total: int) -> None:
            bars.update(upload, completed=done, total=total)

        def on_block(block: AlignedBlock) -> None:
            bars.update(patterns, completed=block.first_pattern + len(block.values))
            look(block)

        try:
            return instrument.run(plan, out, overwrite=overwrite, on_upload=on_upload, on_block=on_block)
        except KeyboardInterrupt as interrupt:
            kept = "; ".join(getattr(interrupt, "__notes__", ())) or "nothing was recorded"
            warn(f"interrupted: the bench is safe; {kept}")
            raise typer.Exit(130) from None


@contextmanager
def _bars_alone(bars: Progress) -> Generator[OnBlock, None, None]:
    with bars:
        yield lambda _block: None


@contextmanager
def _looked_at(plan: Plan, bars: Progress) -> Generator[OnBlock, None, None]:
    """Follow each block that is passed on, draw motion and image below the bars, and tell what the view missed."""
    with LiveView(bars) as view, LiveAnalysis(plan, view.show) as analysis:
        yield analysis.on_block
    if analysis.error is not None:
        warn(f"the live view ended early, the recording did not: {analysis.error}")
    if analysis.counters.frames_dropped:
        warn(f"{analysis.counters.frames_dropped} frames came too fast for the live view; the recording has them all")


def check(bench: BenchOption, plan: PlanOption, as_json: JsonOption = False) -> None:
    """Check a plan against the bench: timing, memory, count rate, travel. Nothing moves and nothing is shown."""
    with Instrument.from_toml(bench) as instrument:
        report = instrument.check(Plan.from_toml(plan))
    if as_json:
        rows = [{"name": c.name, "outcome": c.outcome, "message": c.message} for c in report.checks]
        print_json({"ok": report.ok, "checks": rows})
    else:
        OUT.print(check_table(report))
    if not report.ok:
        raise typer.Exit(2)
