"""Names of files as other computers know them."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Self

from protocols import InputError


@dataclass(frozen=True)
class PathMap:
    """Folders here, and what workers call them. A path that lies in none of them has the same name everywhere."""

    folders: tuple[tuple[Path, str], ...] = ()
    """A folder here, absolute, and its name there."""

    @classmethod
    def of(cls, entries: Iterable[str]) -> Self:
        """Read entries such as ``/home/ann/data=/mnt/lab/data``.

        Raises:
            InputError: an entry without ``=``, or with an empty side.
        """
        folders: list[tuple[Path, str]] = []
        for entry in entries:
            here, equals, there = entry.partition("=")
            if not (equals and here and there):
                raise InputError(
                    saw=f"the path map {entry!r}",
                    expected="HERE=THERE: a folder of this computer, and its name on the workers",
                    remedy="give it so, such as --path-map /home/ann/data=/mnt/lab/data",
                )
            folders.append((Path(here).absolute(), there))
        return cls(tuple(folders))

    def there(self, path: str | Path) -> str:
        """Give the absolute name that workers have for a path of this computer: by the longest folder that it lies in."""
        here = Path(path).absolute()
        around = [(folder, name) for folder, name in self.folders if here.is_relative_to(folder)]
        if not around:
            return str(here)
        folder, name = max(around, key=lambda entry: len(entry[0].parts))
        kind = PureWindowsPath if "\\" in name else PurePosixPath
        return str(kind(name, *here.relative_to(folder).parts))
