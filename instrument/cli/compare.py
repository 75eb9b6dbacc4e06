"""``kinopix compare``: the image of a moving object held against a reference image, such as one taken at rest."""

from pathlib import Path
from typing import Annotated, Final

import typer

from instrument.cli.options import JsonOption, print_json

_EQUAL_DB: Final = 150.0
"""PSNR from which on images are told to be equal: differences of the 8th digit, as the fit of the shift leaves them."""


def compare_files(
    reference: Annotated[Path, typer.Argument(help="Recording (.h5) of the object at rest: the reference image.")],
    moving: Annotated[Path, typer.Argument(metavar="RUN", help="Recording (.h5) of the moving object.")],
    picture: Annotated[
        Path | None, typer.Option(help="File (.png, .pdf or .svg) with both images and their difference.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Reconstruct both recordings, move one image onto the other, and say how alike they are: PSNR, SSIM, edge width.

    Neither recording is changed.
    """
    from instrument.analysis import compare
    from instrument.storage import open_recording
    from instrument.views import OUT, compared_figure, figures_table, save, say
    from protocols import InputError

    if picture is not None and (picture.suffix.lower() not in {".png", ".pdf", ".svg"} or not picture.parent.is_dir()):
        raise InputError(
            saw=f"the picture {picture}",
            expected="a name that ends in .png, .pdf or .svg, in a folder that exists",
            remedy="correct it",
        )
    found = compare(open_recording(reference), open_recording(moving))
    if picture is not None:
        save(compared_figure(found), picture)
    if as_json:
        print_json({**found.figures.model_dump(), "picture": None if picture is None else str(picture)})
        return
    rows = found.figures.rows()
    if found.figures.psnr_db >= _EQUAL_DB:
        rows["PSNR"] = "both images are equal, to the last digits"
    OUT.print(figures_table(f"{moving} against {reference}", rows))
    if picture is not None:
        say(f"drawn {picture}")
