"""Which recordings a list of files and folders means."""

from collections.abc import Iterable
from pathlib import Path

from protocols import InputError


def recordings_in(places: Iterable[str | Path]) -> list[Path]:
    """List recordings: files as they are given, and of folders every ``.h5`` in them, however deep, by name.

    A recording that is named twice is listed once. What a program is making beside a recording is hidden, and left out.

    Raises:
        InputError: a folder without recordings, or one that cannot be read.
    """
    found: dict[Path, Path] = {}
    for place in map(Path, places):
        inside = _inside(place) if place.is_dir() else [place]
        for path in inside:
            found.setdefault(path.resolve(), path)
    return list(found.values())


def _inside(folder: Path) -> list[Path]:
    paths = sorted(
        path
        for path in folder.rglob("*.h5")
        if path.is_file() and not any(part.startswith(".") for part in path.relative_to(folder).parts)
    )
    if not paths:
        raise InputError(
            saw=f"the folder {folder} without a recording",
            expected="files that end in .h5, in it or in folders inside it",
            remedy="name another folder",
        )
    return paths
