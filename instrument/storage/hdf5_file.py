"""HDF5 files, opened whatever their writers have left them as."""

import errno
from collections.abc import Generator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self

import h5py  # pyright: ignore[reportMissingTypeStubs]

from instrument.storage.hdf5 import Group
from instrument.storage.hdf5_failure import detach_descriptor, never_close
from instrument.storage.left_open import LeftOpen
from instrument.storage.part import is_locked
from instrument.storage.soundness import refuse_cut_off

_h5py: Any = h5py

_FORMAT = ("v110", "v110")
"""File format of HDF5 1.10 (2016), the oldest that can be read while it is written (SWMR)."""


class InUse(OSError):
    """Another program has the file open for writing, and lets nobody read."""


class File(Group):
    """An open HDF5 file; a context manager that closes it."""

    def __init__(
        self, path: Path | LeftOpen, mode: Literal["r", "w", "r+", "swmr", "left"], *, locks: bool = True
    ) -> None:
        """Open or create the file.

        Args:
            path: where it is, or its content for ``left``.
            mode: ``r`` reads, ``w`` creates and empties, ``r+`` goes on with it, ``swmr`` reads a file that a writer has open,
                ``left`` one that a writer had open when it died.
            locks: whether HDF5 locks the file; not where the caller holds the lock already.
        """
        keys = {"libver": _FORMAT} if mode in {"w", "r+"} else {"swmr": mode == "swmr"}
        # Network drives often have no locks: that must not keep anybody from recording.
        locking = "best-effort" if locks else False
        self._descriptor = -1
        if isinstance(path, LeftOpen):
            super().__init__(_h5py.File(path, "r"))
            return
        super().__init__(_h5py.File(path, "r" if mode == "swmr" else mode, locking=locking, **keys))
        self._descriptor = int(self._handle.id.get_vfd_handle())  # asked now: later HDF5 may be in a call that hangs

    def let_others_read(self) -> None:
        """From now on others may read while this file is written, and it stays readable at whatever moment the writer dies.

        No group, dataset or attribute can be added after this; datasets can grow.
        """
        self._handle.swmr_mode = True

    @property
    def is_open(self) -> bool:
        """Whether it is open."""
        return bool(self._handle)

    def detach(self) -> None:
        """Part from a file that can no longer be written, and leave it as it is.

        HDF5 crashes when it closes a file after a write that failed, and looks without end for metadata that somebody has cut
        off. So its descriptor is turned to the null device, which takes everything: nothing that HDF5 does afterwards, also at
        the end of the process, reaches the file or can fail. No lock of HDF5 is needed, so a call that hangs is no obstacle.
        """
        if self._descriptor < 0:
            return
        detach_descriptor(self._descriptor)

    def leave_open(self) -> None:
        """Never close this file: HDF5 failed with it, and may crash."""
        never_close(self._handle)

    def close(self) -> None:
        """Close the file; allowed twice."""
        self._handle.close()
        self._descriptor = -1

    def __enter__(self) -> Self:
        """Give the open file."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self.close()


def is_hdf5(path: Path) -> bool:
    """Whether the file begins as an HDF5 file does."""
    return bool(_h5py.is_hdf5(path))


@contextmanager
def open_to_read(path: Path) -> Generator[File]:
    """Open a file whole, or as its writer left it when it died, or as it is while it is being written.

    Raises:
        InUse: another program has it open for writing, and lets nobody read.
        OSError: it is damaged.
    """
    try:
        file = File(path, "r")
    except OSError as error:
        if "already open for" not in str(error) and error.errno not in {errno.EAGAIN, errno.EACCES}:
            raise
        refuse_cut_off(path)
        if is_locked(path) is False:
            with path.open("rb") as content, LeftOpen(content) as left:
                if left.is_marked:
                    with File(left, "left") as file:
                        yield file
                    return
        file = _open_while_written(path)
    with file:
        yield file


def _open_while_written(path: Path) -> File:
    try:
        return File(path, "swmr")
    except OSError as error:
        if error.errno in {errno.EAGAIN, errno.EACCES}:
            raise InUse(str(error)) from error
        if "not already open for SWMR" in str(error):
            raise OSError("a program died while it changed the file, and did not close it") from error
        raise


@contextmanager
def opened_bytes(content: bytes) -> Generator[File]:
    """Open what a writer left, from memory.

    Raises:
        OSError: it is no HDF5 file.
    """
    with LeftOpen(BytesIO(content)) as left, File(left, "left") as file:
        yield file
