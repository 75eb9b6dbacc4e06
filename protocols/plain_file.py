"""Reading a file that somebody else named: a plain file of bounded size, and nothing that could hang or never end.

Settings name files, and names can lead anywhere: to a named pipe that nobody writes to, to ``/dev/zero``, to a socket, to a file
of 100 GB. All of them are refused before the first byte is read, without waiting.
"""

import errno
import os
import stat
from pathlib import Path
from typing import BinaryIO, Final, cast

from protocols.errors import InputError

_LONGEST_PART: Final = 255
"""Bytes of a file's or a folder's name at most, as ext4, NTFS and APFS have it."""

_LONGEST_PATH: Final = 4095
"""Bytes of a whole path at most, as Linux has it."""

_KINDS: Final = (
    (stat.S_ISFIFO, "a named pipe (FIFO)"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


def path_of(name: object) -> Path:
    """Give what somebody passed for a file as a path, if any system could take it for one.

    Raises:
        InputError: it is no text and no path, has a NUL byte, or is longer than names may be.
    """
    if not isinstance(name, str | os.PathLike):
        raise _no_name(f"a {type(name).__name__} in the place of a file")
    path = Path(cast("str | os.PathLike[str]", name))
    if "\0" in str(path):
        raise _no_name(f"the name {str(path)!r}, which has a NUL byte")
    longest = max((len(os.fsencode(part)) for part in path.parts), default=0)
    if longest > _LONGEST_PART or len(os.fsencode(path)) > _LONGEST_PATH:
        raise _no_name(f"a name of {max(longest, len(os.fsencode(path)))} bytes, which begins {str(path)[:40]!r}")
    return path


def _no_name(saw: str) -> InputError:
    return InputError(
        saw=saw,
        expected=f"the name of a file: text or a path, each part of at most {_LONGEST_PART} bytes",
        remedy="pass the name as it stands in the folder",
    )


class NoPlainFile(OSError):
    """What the name leads to is there, but it is no plain file, or too large. ``strerror`` says in words what was seen."""


def open_plain(path: Path, most_bytes: int) -> BinaryIO:
    """Open a file for reading, if it is a plain one (perhaps by a link) of at most ``most_bytes``. It never waits.

    Raises:
        NoPlainFile: it is a named pipe, a device, a socket, or larger. It was not read.
        IsADirectoryError: it is a folder.
        OSError: it is not there, or it may not be read.
    """
    _refuse(path, path.stat(), most_bytes)  # before it is opened: to open some devices is to use them
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0)
    stream = os.fdopen(os.open(path, flags), "rb")
    try:
        _refuse(path, os.fstat(stream.fileno()), most_bytes)  # the name may lead elsewhere by now
    except OSError:
        stream.close()
        raise
    return stream


def read_plain(path: Path, most_bytes: int) -> bytes:
    """Read a plain file whole.

    Raises:
        NoPlainFile: it is no plain file, or holds more than ``most_bytes``.
        OSError: as ``open_plain``.
    """
    with open_plain(path, most_bytes) as stream:
        data = stream.read(most_bytes + 1)
    if len(data) > most_bytes:  # it grows, or does not tell its size, as those of /proc
        raise _too_large(path, len(data), most_bytes)
    return data


def _refuse(path: Path, status: os.stat_result, most_bytes: int) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, "a folder", str(path))
    for is_kind, words in _KINDS:
        if is_kind(status.st_mode):
            raise NoPlainFile(errno.EINVAL, words, str(path))
    if status.st_size > most_bytes:
        raise _too_large(path, status.st_size, most_bytes)


def _too_large(path: Path, size: int, most_bytes: int) -> NoPlainFile:
    return NoPlainFile(errno.EFBIG, f"{size} bytes or more, where {most_bytes} are the most", str(path))
