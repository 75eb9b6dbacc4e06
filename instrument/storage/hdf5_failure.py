"""What is done where HDF5 fails with a file: it may crash then when it closes it, or never come back."""

import os
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any, Final

_LEFT_OPEN: Final = list[Any]()
"""Objects of files that failed, which are never closed."""


def never_close(item: object) -> None:
    """Keep an object of a file with which HDF5 failed, or the thread on which it does not come back."""
    _LEFT_OPEN.append(item)


def hdf5_has_failed() -> bool:
    """Whether HDF5 failed with a file of this process, or does not come back from it: it may crash when the process ends."""
    return bool(_LEFT_OPEN)


@contextmanager
def writing(handle: Any) -> Generator[None]:
    """Detach the file at once where a write fails: closing any object of it, which Python does by itself, may crash HDF5."""
    try:
        yield
    except (OSError, RuntimeError):
        never_close(handle)
        detach_descriptor(int(handle.file.id.get_vfd_handle()))
        raise


def detach_descriptor(descriptor: int) -> None:
    """Turn a descriptor to the null device, which takes everything."""
    nothing = os.open(os.devnull, os.O_RDWR)
    try:
        os.dup2(nothing, descriptor)
    finally:
        os.close(nothing)
