"""The error of a run whose counts the disk does not take."""

import re
from pathlib import Path
from typing import Final

from protocols import KinopixError

_OF_SYSTEM: Final = re.compile(r"error message = '([^']*)'")
_LONGEST: Final = 300


class StorageFailed(KinopixError):
    """The disk does not take what is counted, so the run ends. The notes say what is kept, and where."""

    def __init__(self, path: Path, why: str, remedy: str, *, hangs: bool = False, cut: bool = False) -> None:
        """Name the recording and the reason.

        Args:
            path: the recording.
            why: what the disk, or the file, did.
            remedy: what to do, in the imperative.
            hangs: whether a call to the disk has not come back, so that its thread cannot be ended.
            cut: whether somebody else has destroyed what was in the recording.
        """
        self.hangs = hangs
        self.cut = cut
        super().__init__(saw=f"{path}, {why}", expected="a disk that takes every block of counts", remedy=remedy)


def failed(path: Path, error: BaseException) -> StorageFailed:
    """Say what an exception of a write means."""
    if isinstance(error, StorageFailed):
        return error
    said = _OF_SYSTEM.search(str(error))  # HDF5 tells it among addresses and sizes
    why = said[1] if said else " ".join(str(error).split())[:_LONGEST] or type(error).__name__
    return StorageFailed(path, f"which could not be written: {why}", "make room on the disk or look at its health")


def cut_off(path: Path, size: int) -> StorageFailed:
    """Make the error for a file that lost a part of what was written into it; it has ``size`` bytes now."""
    return StorageFailed(
        path,
        f"which another program has cut while it was recorded: it has {size} bytes now",
        "find the program that wrote into the folder, and let it leave recordings alone",
        cut=True,
    )


def no_answer(path: Path, waited_s: float) -> StorageFailed:
    """Make the error for a disk that does not come back from a call."""
    return StorageFailed(
        path,
        f"whose disk has not answered for {waited_s:.1f} s",
        "look at the disk and its cable or network, or record to another one",
        hangs=True,
    )
