"""``kinopix film``: a recording as a film."""

from pathlib import Path
from typing import Annotated

import typer

from instrument.cli.analyse import analysed
from instrument.cli.options import JsonOption, OverwriteOption, print_json, refuse_taken


def film(
    file: Annotated[Path, typer.Argument(help="Recording (.h5), whole or partial.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Film to write, .mp4 or .gif; the recording's name with .gif if not given."),
    ] = None,
    pictures: Annotated[int, typer.Option(min=2, max=2000, help="Number of pictures; 15 are shown a second.")] = 60,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Show a run as a film: the object moves, and its image forms from more and more frames."""
    from instrument.storage import open_recording
    from instrument.views import progress, refuse_no_film, say, write_film

    path = file.with_suffix(".gif") if out is None else out
    refuse_no_film(path)
    refuse_taken(path, overwrite=overwrite)
    analysis = analysed(open_recording(file))
    with progress() as bars:
        task = bars.add_task("film", total=None)
        write_film(
            analysis,
            path,
            pictures=pictures,
            on_picture=lambda done, total: bars.update(task, completed=done, total=total),
        )
    if as_json:
        print_json({"film": str(path), "pictures": pictures})
    else:
        say(f"written {path}")
