"""``kinopix analyse --window``: a recording of any length, window by window."""

from pathlib import Path
from typing import Final

from instrument.cli.options import print_json

_ALL: Final = "all"
_NONE: Final = "none"


def in_windows(file: Path, window: int, images: str, results: Path | None, *, as_json: bool) -> None:
    """Analyse a recording in windows with a progress bar, and print the figures.

    Raises:
        InputError: no list of windows, or as ``analyse_in_windows``.
    """
    wanted = _numbers(images)
    from instrument.analysis import analyse_in_windows
    from instrument.views import OUT, figures_table, progress, warn

    with progress() as bars:
        task = bars.add_task("analysis", total=None)
        done = analyse_in_windows(
            file,
            window_frames=window,
            images=wanted,
            results=results,
            on_step=lambda what, number, total: bars.update(task, description=what, completed=number, total=total),
        )
    for doubt in done.figures.doubts:
        warn(doubt)
    if as_json:
        print_json(done.figures.model_dump(mode="json"))
        return
    rows = {**done.figures.rows(), "windows": f"{len(done.windows)}, {len(done.images)} with an image"}
    OUT.print(figures_table(f"Analysis of {file.name}", rows))


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
            expected="one recording, analysed with every default",
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
