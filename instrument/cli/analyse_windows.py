"""``kinopix analyse --window``: a recording of any length, window by window."""

from pathlib import Path
from typing import TYPE_CHECKING, Final

from instrument.cli.options import print_json

if TYPE_CHECKING:
    from instrument.views import PictureFormat

_ALL: Final = "all"
_NONE: Final = "none"


def in_windows(
    file: Path,
    window: int,
    images: str,
    results: Path | None,
    *,
    background: str,
    pictures: Path | None,
    kind: "PictureFormat",
    as_json: bool,
) -> None:
    """Analyse a recording in windows with a progress bar, print the figures, and draw the pictures.

    Args:
        file: the recording.
        window: frames of a window.
        images: of which windows an image is made.
        results: a new file for a copy with the analysis; None for the recording itself.
        background: what stands still, as ``analyse_in_windows`` takes it.
        pictures: folder for the pictures; None draws none.
        kind: of pictures.
        as_json: whether the figures are printed as JSON.

    Raises:
        InputError: no list of windows, or as ``analyse_in_windows``.
    """
    wanted = _numbers(images)
    from instrument.analysis import analyse_in_windows
    from instrument.views import OUT, figures_table, picture_folder, progress, say, warn, write_window_pictures

    if pictures is not None:
        picture_folder(pictures)  # asked before the work, not after
    with progress() as bars:
        task = bars.add_task("analysis", total=None)
        done = analyse_in_windows(
            file,
            window_frames=window,
            images=wanted,
            background=background,
            results=results,
            on_step=lambda what, number, total: bars.update(task, description=what, completed=number, total=total),
        )
    for doubt in done.figures.doubts:
        warn(doubt)
    drawn = [] if pictures is None else write_window_pictures(done, pictures, (results or file).stem, kind)
    if as_json:
        print_json({**done.figures.model_dump(mode="json"), "pictures": [str(path) for path in drawn]})
        return
    rows = {**done.figures.rows(), "windows": f"{len(done.windows)}, {len(done.images)} with an image"}
    OUT.print(figures_table(f"Analysis of {file.name}", rows))
    for path in drawn:
        say(f"drawn {path}")


def refuse_beside_window(**given: bool) -> None:
    """Refuse what an analysis in windows does not do.

    Args:
        given: name of each option, with ``_`` for ``-``, and whether it was given; ``files`` for several recordings.

    Raises:
        InputError: names them.
    """
    from protocols import InputError

    names = [name for name, was in given.items() if was]
    if names:
        asked = ["several recordings" if name == "files" else f"--{name.replace('_', '-')}" for name in names]
        raise InputError(
            saw=f"--window with {', '.join(asked)}",
            expected="one recording, analysed with every default but --background",
            remedy="leave out the one or the other",
        )


def _numbers(images: str) -> list[int] | None:
    """Read which windows are meant: None for all."""
    from protocols import InputError

    if images in {_ALL, _NONE}:
        return None if images == _ALL else []
    numbers = images.split(",")
    if not all(number.strip().isdecimal() for number in numbers):
        raise InputError(
            saw=f"--window-images {images}",
            expected="all, none, or numbers of windows such as 0,3,7",
            remedy="correct it",
        )
    return [int(number) for number in numbers]
