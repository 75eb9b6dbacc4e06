"""A file that is made beside its place, under a name that nobody can guess, until it is fit to take that place."""

import os
import re
import secrets
import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final, Literal, TypeAlias

if sys.platform != "win32":
    import fcntl

Purpose: TypeAlias = Literal["recorded", "analysed"]
"""What a file is being made for."""

RENAMES_OPEN_FILES: Final = sys.platform != "win32"
"""Whether the system lets a file be renamed that is open."""

_FLAGS: Final = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0)
_LOOK: Final = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)


class Part:
    """A file beside ``target`` that is locked as long as this program lives, and takes the place of ``target`` at the end.

    Its name carries the process, and 64 random bits. It is created exclusively and no link is followed, so nobody can have
    planted a file or a link under its name. The lock (``flock``) ends with the process, however that ends: a part without a
    lock was left behind by a program that died.
    """

    def __init__(self, target: Path, purpose: Purpose) -> None:
        """Create the file, empty; a copy that is analysed can be read by nobody else until it is given its mode.

        Raises:
            OSError: it cannot be created.
        """
        self.target = target
        """Where it goes."""
        self.path, self._file = _created(target, purpose)
        """Where it is."""

    def fileno(self) -> int:
        """Give a descriptor of the file that is open for writing; -1 where Windows had to close it."""
        return self._file

    def put_in_place(self, *, replace: bool) -> None:
        """Rename it to its target, at once for all who look. The lock goes along.

        Args:
            replace: whether a file that is there may be lost. Whoever has it open keeps it.

        Raises:
            FileExistsError: ``replace`` is not set, and the target is there.
            OSError: the system does not allow it.
        """
        if not RENAMES_OPEN_FILES:
            self.release()
        if replace:
            self.path.replace(self.target)
        else:
            _rename_to_new(self.path, self.target)
        self.path = self.target
        sync_folder(self.target.parent)

    def put_beside(self) -> Path:
        """Rename it to a new name beside its target, and give that name."""
        self.target = self.target.with_name(f"{self.target.stem}-{secrets.token_hex(4)}{self.target.suffix}")
        self.put_in_place(replace=False)
        return self.target

    def unlock(self) -> None:
        """Leave the lock to HDF5, which takes one of its own while it creates a file."""
        if sys.platform != "win32":
            with suppress(OSError):
                fcntl.flock(self._file, fcntl.LOCK_UN)

    def let_others_read(self) -> None:
        """Lock it again, so that other writers are kept out and no reader is.

        Raises:
            OSError: in the moment without a lock, somebody has removed it as one that was left behind.
        """
        if sys.platform != "win32":
            with suppress(OSError):
                fcntl.flock(self._file, fcntl.LOCK_SH)
            if not os.path.samestat(self.path.lstat(), os.fstat(self._file)):
                raise FileNotFoundError(self.path)

    def discard(self) -> None:
        """Remove the file, wherever it is now, and the lock."""
        if not RENAMES_OPEN_FILES:
            self.release()
        self.path.unlink(missing_ok=True)
        self.release()

    def release(self) -> None:
        """Take the lock away; allowed twice."""
        if self._file >= 0:
            file, self._file = self._file, -1
            os.close(file)


@dataclass(frozen=True)
class Found:
    """A part that is there."""

    path: Path
    """Where it is."""

    purpose: str
    """What it is being made for, as ``Purpose``."""

    process: int
    """Whose it is, or was."""

    since: str
    """When it was written last, ISO 8601 in UTC."""

    alive: bool | None
    """Whether its program lives; None where the file system has no locks, and nothing tells."""


@contextmanager
def alone_in(folder: Path) -> Generator[None]:
    """Keep others out of this block in the same folder, so that of two who come at the same moment one sees the other.

    Where a folder cannot be locked (Windows, some network drives), nobody is kept out: then each may see the other.
    """
    opened = -1
    with suppress(OSError):
        if sys.platform != "win32":
            opened = os.open(folder, os.O_RDONLY)
            fcntl.flock(opened, fcntl.LOCK_EX)
    try:
        yield
    finally:
        if opened >= 0:
            os.close(opened)


def parts_of(target: Path) -> list[Found]:
    """Give the parts that programs are making for ``target``, or have left behind."""
    name = re.compile(rf"\.{re.escape(target.name)}\.(recorded|analysed)-(\d+)-[0-9a-f]{{16}}\.part")
    found: list[Found] = []
    with suppress(OSError), os.scandir(target.parent) as entries:
        for entry in entries:
            match = name.fullmatch(entry.name)
            if match is None or not entry.is_file(follow_symlinks=False):
                continue
            with suppress(FileNotFoundError):
                since = datetime.fromtimestamp(entry.stat().st_mtime, UTC).isoformat(timespec="seconds")
                path = Path(entry.path)
                found.append(Found(path, match[1], int(match[2]), since, is_locked(path)))
    return sorted(found, key=lambda part: part.path)


def remains_of(path: Path) -> list[Path]:
    """Name what programs that died have left beside a recording that they were making or analysing."""
    return [part.path for part in parts_of(path.resolve()) if part.alive is False]


def remove_remains(path: Path) -> list[Path]:
    """Remove what ``remains_of`` names, and give the names.

    Nothing is lost: a part that holds counts of its own has taken its place already.
    """
    removed: list[Path] = []
    for part in remains_of(path):
        with suppress(OSError):
            part.unlink()
            removed.append(part)
    return removed


def is_locked(path: Path) -> bool | None:
    """Whether a program holds a lock on a file; None where that cannot be told. No link is followed.

    Raises:
        FileNotFoundError: there is no such file.
    """
    if sys.platform == "win32":
        try:
            path.rename(path)  # the system refuses it for a file that is open
        except PermissionError:
            return True
        return False
    try:
        file = os.open(path, _LOOK)
    except PermissionError:
        return None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return None
    else:
        return False
    finally:
        os.close(file)


def _created(target: Path, purpose: Purpose) -> tuple[Path, int]:
    while True:
        path = target.with_name(f".{target.name}.{purpose}-{os.getpid()}-{secrets.token_hex(8)}.part")
        file = os.open(path, _FLAGS, 0o666 if purpose == "recorded" else 0o600)
        if sys.platform == "win32":
            return path, file
        with suppress(OSError):  # a file system without locks
            fcntl.flock(file, fcntl.LOCK_EX)  # waits for those who look at this moment whether it is locked
        with suppress(FileNotFoundError):
            if os.path.samestat(path.lstat(), os.fstat(file)):
                return path, file
        os.close(file)  # somebody took it for one that was left behind, before it was locked


def _rename_to_new(path: Path, target: Path) -> None:
    if sys.platform == "win32":
        path.rename(target)  # refuses a name that is taken
        return
    try:
        os.link(path, target, follow_symlinks=False)
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links
        if os.path.lexists(target):
            raise FileExistsError(target) from None
        path.rename(target)
    else:
        path.unlink()


def sync_folder(folder: Path) -> None:
    """Make sure that the new name survives a power cut, where the system can."""
    if sys.platform == "win32":
        return
    with suppress(OSError):
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)
