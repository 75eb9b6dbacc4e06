"""Room on the disk that is taken before HDF5 needs it: HDF5 cannot go on after a write that failed.

On Linux the blocks of the file are allocated ahead by ``fallocate``, without changing its length, so that nobody else can take
them. Where the system or the file system cannot do that, the free room is looked at instead, and another program may still be
faster.
"""

import ctypes
import errno
import math
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, cast

if sys.platform != "win32":
    import resource

AHEAD: Final = 8 << 20
"""Bytes that are taken at a time: twenty seconds of counts at 20 kHz, and what the end of a run needs."""

_SLACK: Final = 1 << 18
"""By so much a file system may change its mind on the blocks of a file; a cut frees all that were taken ahead."""

_KEEP_SIZE: Final = 1  # FALLOC_FL_KEEP_SIZE of linux/falloc.h
_CANNOT: Final = {errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL}


class Room:
    """The blocks of one file that is being written."""

    def __init__(self, path: Path, file: int) -> None:
        """Nothing is taken yet.

        Args:
            path: the file, to find its disk.
            file: an open descriptor of it.
        """
        self._folder = path.parent
        self._file = file
        self._taken = 0
        self._counted = False  # whether the file system tells of blocks that are taken

    def take(self, end: int) -> None:
        """Make sure that the file can grow to ``end`` bytes.

        Raises:
            OSError: it cannot: the disk is full (``ENOSPC``), or files may not be so long (``EFBIG``).
        """
        if end > longest_file():
            raise OSError(
                errno.EFBIG, f"{os.strerror(errno.EFBIG)}: the system allows files of {longest_file():.0f} bytes"
            )
        if end <= self._taken:
            return
        ahead = end + AHEAD
        try:
            _allocate(self._file, ahead, self._folder)
        except OSError:
            _allocate(self._file, ahead := end, self._folder)
        self._taken = ahead
        self._counted = _allocated_bytes(self._file) >= ahead

    def lost(self) -> bool:
        """Whether blocks that were taken are gone: another program has cut the file, even if it is as long again since."""
        return self._counted and _allocated_bytes(self._file) < self._taken - _SLACK

    def give_back(self) -> None:
        """Give back what was taken beyond the end of the file."""
        if sys.platform == "linux" and self._taken:
            os.ftruncate(self._file, os.fstat(self._file).st_size)
            self._taken, self._counted = 0, False


def longest_file() -> float:
    """Give the most bytes that the system lets this process write into one file."""
    if sys.platform == "win32":
        return math.inf
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
    return math.inf if limit == resource.RLIM_INFINITY else limit


def _allocated_bytes(file: int) -> int:
    return 512 * getattr(os.fstat(file), "st_blocks", 0)


def _allocate(file: int, end: int, folder: Path) -> None:
    if sys.platform == "linux" and _FALLOCATE is not None:
        while _FALLOCATE(file, _KEEP_SIZE, 0, end) != 0:
            code = ctypes.get_errno()
            if code in _CANNOT:
                break
            if code != errno.EINTR:
                raise OSError(code, os.strerror(code))
        else:
            return
    free = shutil.disk_usage(folder).free
    missing = end - os.fstat(file).st_size
    if free < missing:
        raise OSError(errno.ENOSPC, f"{os.strerror(errno.ENOSPC)}: {free} bytes free")


def _fallocate() -> Callable[[int, int, int, int], int] | None:
    if sys.platform != "linux":
        return None
    try:
        function: Any = ctypes.CDLL(None, use_errno=True).fallocate64
    except (OSError, AttributeError):
        return None
    function.argtypes = (ctypes.c_int, ctypes.c_int, ctypes.c_int64, ctypes.c_int64)
    function.restype = ctypes.c_int
    return cast("Callable[[int, int, int, int], int]", function)


_FALLOCATE: Final = _fallocate()
