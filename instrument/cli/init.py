"""``kinopix init``: a bench.toml and a plan.toml to begin with."""

from pathlib import Path
from typing import Annotated

import typer

from instrument.cli.options import JsonOption, OverwriteOption, print_json


def init(
    folder: Annotated[Path, typer.Argument(help="Folder for both files; it is made if it is not there.")] = Path(),
    modulator: Annotated[
        str, typer.Option(help="Driver of the modulator; `kinopix drivers` lists them.")
    ] = "simulated",
    counter: Annotated[str, typer.Option(help="Driver of the counter.")] = "simulated",
    stage: Annotated[str, typer.Option(help="Driver of the stage.")] = "simulated",
    scheme: Annotated[str, typer.Option(help="What one frame shows.")] = "fourier-hadamard",
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Write a commented bench.toml and plan.toml for the chosen drivers, with the schemas that an editor completes keys by."""
    import json

    from instrument.config import bench_schema, bench_template, plan_schema, plan_template
    from instrument.plan import Plan
    from instrument.views import say
    from protocols import InputError

    bench, plan = bench_schema(), plan_schema(Plan)
    texts = {
        "bench.toml": bench_template(bench, {"modulator": modulator, "counter": counter, "stage": stage}),
        "plan.toml": plan_template(plan, scheme),
        "bench.schema.json": json.dumps(bench, indent=1) + "\n",
        "plan.schema.json": json.dumps(plan, indent=1) + "\n",
    }
    there = [name for name in texts if (folder / name).exists()]
    if there and not overwrite:
        raise InputError(
            saw=f"{', '.join(there)} in {folder} already",
            expected="a folder without them",
            remedy="choose another folder, or --overwrite",
        )
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
        if not as_json:
            say(f"written {folder / name}")
    needed = [line.split("=")[0].strip("# ") for line in texts["bench.toml"].splitlines() if "# needed:" in line]
    if as_json:
        print_json({"written": [str(folder / name) for name in texts], "needed": needed})
    elif needed:
        say(f"bench.toml needs what only you can know: {', '.join(needed)}")
