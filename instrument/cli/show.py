"""``kinopix show``: one picture on the modulator, held."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from instrument.cli.options import BenchOption, ImageSizeOption, JsonOption, SuperpixelOption, print_json

if TYPE_CHECKING:
    from protocols import Bytes


def show(
    picture: Annotated[
        str,
        typer.Argument(
            metavar="PICTURE",
            help="white, black, half (left), checker[:px], fringe[:periods], crosshair, letter, columns:a-b, rows:a-b, "
            "block:top,left,height,width, or a picture file.",
        ),
    ],
    bench: BenchOption,
    seconds: Annotated[float | None, typer.Option(help="How long to hold it; without it until Ctrl-C.")] = None,
    image_size: ImageSizeOption = 128,
    superpixel: SuperpixelOption = 2,
    as_json: JsonOption = False,
) -> None:
    """Hold one picture on the modulator until Ctrl-C, or for some seconds. No other device is touched.

    The mirrors go dark, or flat, on every way out. White lights the whole field, crosshair shows its middle and border, and
    the letter F looks different in each of the eight ways in which an image can lie.
    """
    from instrument.cli.libraries import tell_libraries
    from instrument.session import Instrument
    from instrument.views import say
    from protocols import InputError

    if as_json and seconds is None:
        raise InputError(saw="--json without --seconds", expected="a time", remedy="add --seconds 10")
    lit = _lit(picture, image_size)
    tell_libraries(bench, ("modulator",))
    with Instrument.from_toml(bench, only=("modulator",)) as instrument:
        limits, side = instrument.modulator.limits, image_size * superpixel
        how_long = "until Ctrl-C" if seconds is None else f"for {seconds:g} s"
        if not as_json:
            say(f"{picture}: {side} x {side} of {limits.columns} x {limits.rows} mirrors, {how_long}")
        instrument.show(lit, seconds, image_size=image_size, superpixel=superpixel)
    if as_json:
        mirrors = {"columns": limits.columns, "rows": limits.rows}
        print_json({"picture": picture, "seconds": seconds, "side_mirrors": side, **mirrors, "dark": True})
    else:
        say("the modulator is dark")


def _lit(picture: str, image_size: int) -> "Bytes":
    """The picture of that name, or from the file of that name."""
    from instrument.patterns import picture as named
    from instrument.patterns import picture_of_file

    path = Path(picture)
    return picture_of_file(path, image_size) if path.suffix else named(picture, image_size)
