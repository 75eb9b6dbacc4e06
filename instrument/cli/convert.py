"""``kinopix convert``: what another program has recorded, as a recording."""

from pathlib import Path
from typing import Annotated

import typer

from instrument.cli.options import JsonOption, OverwriteOption, print_json, refuse_no_amount


def convert(
    file: Annotated[
        Path,
        typer.Argument(
            help="One of the pair of SPAS (NAME_spectraldata.npz, NAME_metadata.json), or .npz, .npy, .mat."
        ),
    ],
    out: Annotated[
        Path | None, typer.Option("--out", help="Recording to write (.h5); the file's name with .h5 if not given.")
    ] = None,
    key: Annotated[str | None, typer.Option("--key", help="Name of the array, where the file has several.")] = None,
    order: Annotated[
        str | None, typer.Option("--order", help="Order of the Hadamard patterns, as natural; SPAS tells it itself.")
    ] = None,
    picture_time_us: Annotated[
        float | None,
        typer.Option("--picture-time-us", help="Time from one pattern to the next, where the file has none."),
    ] = None,
    band_nm: Annotated[
        tuple[float, float] | None,
        typer.Option("--band-nm", help="SPAS: first and last wavelength that are summed; all if not given."),
    ] = None,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Make a recording of Hadamard measurements by other programs, and say what is missing in it."""
    from dataclasses import asdict

    from instrument.foreign import convert as write
    from instrument.foreign import is_spas, read_array, read_spas
    from instrument.views import say, warn

    if picture_time_us is not None:
        refuse_no_amount(picture_time_us=picture_time_us)
    spas = is_spas(file)
    found = read_spas(file, band_nm) if spas else read_array(file, key, order)
    place = out or file.with_name(f"{file.name.rsplit('_', 1)[0] if spas else file.stem}.h5")
    done = write(
        found,
        place,
        picture_time_s=None if picture_time_us is None else picture_time_us * 1e-6,
        overwrite=overwrite,
    )
    for sentence in done.missing:
        warn(sentence)
    if as_json:
        print_json(asdict(done) | {"path": str(done.path)})
    else:
        size = found.image_size
        say(
            f"{done.path}: {done.frames_measured} of {done.frames} frames, {size} x {size} px; kinopix analyse {done.path}"
        )
