"""Options that several sub-commands share, each written once."""

import json
from pathlib import Path
from typing import Annotated, TypeAlias

import typer
from pydantic import BaseModel

BenchOption: TypeAlias = Annotated[Path, typer.Option("--bench", help="bench.toml: which drivers, and their settings.")]
PlanOption: TypeAlias = Annotated[
    Path, typer.Option("--plan", help="plan.toml: what is shown, how fast, how it moves.")
]
JsonOption: TypeAlias = Annotated[bool, typer.Option("--json", help="Print the figures as JSON to standard output.")]
OverwriteOption: TypeAlias = Annotated[bool, typer.Option("--overwrite", help="Replace files that exist.")]


def print_json(figures: BaseModel | dict[str, object]) -> None:
    """Print figures as JSON to standard output."""
    plain = figures.model_dump(mode="json") if isinstance(figures, BaseModel) else figures
    typer.echo(json.dumps(plain, indent=2, allow_nan=False))
