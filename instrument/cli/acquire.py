"""``kinopix run`` and ``kinopix check``."""

from pathlib import Path
from typing import Annotated

import typer

from instrument.acquisition import AlignedBlock
from instrument.cli.options import BenchOption, JsonOption, OverwriteOption, PlanOption, print_json
from instrument.instrument import Instrument
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.views.terminal import ERR, OUT, check_table, progress, timing_table


def run(
    bench: BenchOption,
    plan: PlanOption,
    out: Annotated[Path, typer.Option("--out", help="Recording to write (.h5).")],
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Acquire: move the stage, play the patterns, count the light, write the recording while it runs."""
    recording = record(bench, Plan.from_toml(plan), out, overwrite=overwrite)
    if recording.timing is None:
        return
    if as_json:
        print_json({"recording": str(out), "timing": recording.timing.model_dump(mode="json")})
    else:
        OUT.print(timing_table(recording.timing))
        OUT.print(f"recorded {len(recording)} frames in {out}", soft_wrap=True)


def record(bench: Path, plan: Plan, out: Path, *, overwrite: bool) -> Recording:
    """Run one plan with progress bars.

    Raises:
        KinopixError: as ``Instrument.run``; Ctrl-C ends the command with 130 after the bench was made safe.
    """
    with Instrument.from_toml(bench) as instrument, progress() as bars:
        upload = bars.add_task("patterns uploaded", total=None)
        patterns = bars.add_task("patterns counted", total=6 * plan.frames)

        def on_upload(done: int, total: int) -> None:
            bars.update(upload, completed=done, total=total)

        def on_block(block: AlignedBlock) -> None:
            bars.update(patterns, completed=block.first_pattern + len(block.values))

        try:
            return instrument.run(plan, out, overwrite=overwrite, on_upload=on_upload, on_block=on_block)
        except KeyboardInterrupt:
            ERR.print(f"interrupted: the bench is safe, and what was recorded is in {out}", soft_wrap=True)
            raise typer.Exit(130) from None


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
