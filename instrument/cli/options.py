"""Options that several sub-commands share, each written once."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Final, TypeAlias

import typer

BenchOption: TypeAlias = Annotated[Path, typer.Option("--bench", help="bench.toml: which drivers, and their settings.")]
PlanOption: TypeAlias = Annotated[
    Path, typer.Option("--plan", help="plan.toml: what is shown, how fast, how it moves.")
]
JsonOption: TypeAlias = Annotated[bool, typer.Option("--json", help="Print the figures as JSON to standard output.")]
ImageSizeOption: TypeAlias = Annotated[int, typer.Option("--image-size", help="Image pixels a side of the field.")]
SuperpixelOption: TypeAlias = Annotated[int, typer.Option("--superpixel", help="Mirrors a side of one image pixel.")]
OverwriteOption: TypeAlias = Annotated[bool, typer.Option("--overwrite", help="Replace files that exist.")]
WorkersOption: TypeAlias = Annotated[
    int | None,
    typer.Option("--workers", min=1, max=512, help="Number of processes; as many as there are cores if not given."),
]
SchedulerOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers compute, such as tcp://host:8786."
    ),
]
PathMapOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--path-map", metavar="HERE=THERE", help="With --scheduler: a folder here, and what workers call it."),
]
TableOption: TypeAlias = Annotated[
    list[Path] | None,
    typer.Option("--table", help="Table of all recordings, .csv or .parquet; may be given twice."),
]

_TOO_MUCH: Final = 1e9


def refuse_no_amount(**options: float) -> None:
    """Refuse what is no time and no rate, before any device is opened.

    Args:
        options: value by the option's name, with ``_`` for ``-``.

    Raises:
        InputError: a value is not above 0, not finite, or beyond all devices.
    """
    from protocols import InputError

    for name, value in options.items():
        if not 0 < value < _TOO_MUCH:
            raise InputError(
                saw=f"--{name.replace('_', '-')} {value:g}", expected="a number above 0", remedy="correct it"
            )


def refuse_taken(path: Path, *, overwrite: bool) -> None:
    """Make sure that a file that is no recording may be written, before the work.

    Raises:
        InputError: its folder is missing, it is a folder, or it exists and ``overwrite`` is not set.
    """
    from protocols import InputError

    if not path.absolute().parent.is_dir():
        raise InputError(
            saw=f"no folder {path.parent}",
            expected=f"an existing folder for {path.name}",
            remedy="make the folder, or name another one",
        )
    if path.exists() and not (overwrite and path.is_file()):
        raise InputError(
            saw=f"{path}, which exists",
            expected="the name of a new file",
            remedy="name another file" + (", or give --overwrite to lose the old one" if path.is_file() else ""),
        )


def print_json(figures: Mapping[str, object], *, with_warnings: bool = True) -> None:
    """Print figures as JSON to standard output; those that are not finite as null.

    Args:
        figures: by name.
        with_warnings: whether ``warnings`` holds what was warned of until now.
    """
    from instrument.storage import json_text
    from instrument.views import warned

    more = {"warnings": list(warned())} if with_warnings else {}
    typer.echo(json_text({**figures, **more}, indent=2))
