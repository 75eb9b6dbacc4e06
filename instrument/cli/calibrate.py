"""``kinopix calibrate``: what a lab measures of its bench; each sub-command writes one section of the calibration file.

A sub-command lives in a file of its own, ``calibrate_<section>.py``; ``main`` registers it.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias

import typer

if TYPE_CHECKING:
    from instrument.config import BenchConfig

app = typer.Typer(
    help="Measure the bench itself, and write what is found into its calibration file.", no_args_is_help=True
)

CalibrationOption: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--out",
        help="Calibration file (.toml) to write into; the one that bench.toml names, or calibration.toml beside it.",
    ),
]

_DEFAULT: Final = "calibration.toml"


def target(config: "BenchConfig", out: Path | None) -> Path:
    """Give the file that a calibration of a bench is written into: what the user names, what bench.toml names, or the default."""
    return out or config.calibration_path or config.folder / _DEFAULT


def say_written(config: "BenchConfig", path: Path, *, as_json: bool = False) -> None:
    """Tell where a calibration was written, unless the figures say so, and what to add to bench.toml so that runs use it."""
    from instrument.views import say, warn

    if not as_json:
        say(f"wrote {path}")
    if config.calibration_path is None or config.calibration_path.resolve() != path.resolve():
        named = path.name if path.resolve().parent == config.folder.resolve() else path.resolve()
        warn(f'{config.path} does not name this file yet: add calibration = "{named}" above its tables')
