"""``kinopix compare``: the image of a moving object held against a reference image, such as one taken at rest."""

from pathlib import Path
from typing import Annotated

import typer

from instrument.cli.options import JsonOption, print_json


def compare_files(
    reference: Annotated[Path, typer.Argument(help="Recording (.h5) of the object at rest: the reference image.")],
    moving: Annotated[Path, typer.Argument(metavar="RUN", help="Recording (.h5) of the moving object.")],
    picture: Annotated[Path | None, typer.Option(help="PNG file with both images and their difference.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Reconstruct both recordings, move one image onto the other, and say how alike they are: PSNR, SSIM, edge width.

    Neither recording is changed.
    """
    from instrument.analysis import compare
    from instrument.storage import open_recording
    from instrument.views import OUT, compared_figure, figures_table, save, say
    from protocols import InputError

    if picture is not None and (picture.suffix.lower() != ".png" or not picture.parent.is_dir()):
        raise InputError(
            saw=f"the picture {picture}",
            expected="a name that ends in .png, in a folder that exists",
            remedy="correct it",
        )
    found = compare(open_recording(reference), open_recording(moving))
    if picture is not None:
        save(compared_figure(found), picture)
    if as_json:
        print_json({**found.figures.model_dump(), "picture": None if picture is None else str(picture)})
        return
    OUT.print(figures_table(f"{moving.name} against {reference.name}", found.figures.rows()))
    if picture is not None:
        say(f"drawn {picture}")
