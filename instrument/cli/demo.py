"""``kinopix demo``: the whole line on a simulated bench, from nothing to a picture."""

from pathlib import Path
from typing import Annotated

import typer

from instrument.cli.acquire import record
from instrument.cli.analyse import analysed
from instrument.cli.options import JsonOption, OverwriteOption, print_json


def demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for the demo's files.")] = Path("demo"),
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulated noise.")] = 1,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Run a simulated bench and analyse it: a letter moves past one detector, and comes out sharp."""
    from instrument.analysis import store
    from instrument.plan import Plan
    from instrument.storage import refuse_existing
    from instrument.views import OUT, figures_table, picture_folder, say, write_pictures

    picture_folder(out)
    run_h5 = out / "run.h5"
    refuse_existing(run_h5, overwrite=overwrite)
    bench_toml, plan_toml = _write_inputs(out, seed)
    recording = record(bench_toml, Plan.from_toml(plan_toml), run_h5, overwrite=overwrite)
    analysis = analysed(recording, "joint", "tv")
    store(run_h5, recording, analysis)
    drawn = write_pictures(analysis, out)
    if as_json:
        print_json(
            {"seed": seed, **analysis.figures.model_dump(mode="json"), "pictures": [str(path) for path in drawn]}
        )
        return
    OUT.print(figures_table("Demo: a letter that never stood still", {"seed": str(seed), **analysis.figures.rows()}))
    say(f"Look at {out / 'summary.png'}. Then change {plan_toml} or {bench_toml} and do it step by step:")
    run_again = out / "again.h5"
    say(f"  kinopix check   --bench {bench_toml} --plan {plan_toml}")
    say(f"  kinopix run     --bench {bench_toml} --plan {plan_toml} --out {run_again}")
    say(f"  kinopix analyse {run_again}")


def _write_inputs(folder: Path, seed: int) -> tuple[Path, Path]:
    """Put bench.toml and plan.toml into the folder, with the seed asked for."""
    import re
    from importlib.resources import files

    source = files("instrument.cli") / "start"
    bench_toml, plan_toml = folder / "bench.toml", folder / "plan.toml"
    bench = (source / "bench.toml").read_text(encoding="utf-8")
    bench_toml.write_text(re.sub(r"seed = \d+", f"seed = {seed}", bench), encoding="utf-8")
    plan_toml.write_text((source / "plan.toml").read_text(encoding="utf-8"), encoding="utf-8")
    return bench_toml, plan_toml
