"""Whether the numbers of a recording are those that were measured: one CRC-32 for each hundred frames."""

import zlib
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from protocols import Floats

FRAMES_A_BLOCK: Final = 100
"""Frames that share a checksum: so finely is told which frames were changed."""


class Checksums:
    """Checksums of numbers that come one after the other, little-endian float64, a hundred frames at a time."""

    def __init__(self, patterns_per_frame: int) -> None:
        """Nothing has come yet."""
        self._block = FRAMES_A_BLOCK * patterns_per_frame
        self._row = patterns_per_frame
        self._done: list[int] = []
        self._crc = 0
        self._count = 0

    def add(self, values: Floats) -> None:
        """Take the next ones, any number of them."""
        while len(values):
            now = values[: self._block - self._count]
            self._crc = zlib.crc32(np.ascontiguousarray(now, dtype="<f8").tobytes(), self._crc)
            self._count += len(now)
            values = values[len(now) :]
            if self._count == self._block:
                self._close()

    def finished(self) -> NDArray[np.uint32]:
        """Give the checksums of all blocks; the rest of an open frame is NaN, as in the file."""
        self.add(np.full(-self._count % self._row, np.nan))
        if self._count:
            self._close()
        return np.array(self._done, dtype=np.uint32)

    def _close(self) -> None:
        self._done.append(self._crc)
        self._crc = self._count = 0


def changed_frames(rows: Floats, checksums: NDArray[Any], first_frame: int = 0) -> str:
    """Hold ``(frames, patterns)`` against their checksums, and say which frames differ; empty where none does.

    Args:
        rows: numbers of successive frames.
        checksums: of each hundred of them.
        first_frame: number of the first one in the run.
    """
    sums = Checksums(rows.shape[1])
    sums.add(rows.ravel())
    found = sums.finished()
    if found.shape != checksums.shape:
        return f"{len(rows)} frames, where checksums stand for {len(checksums)} times {FRAMES_A_BLOCK}"
    wrong = np.flatnonzero(found != checksums)
    if not len(wrong):
        return ""
    first = int(wrong[0]) * FRAMES_A_BLOCK
    last = first_frame + min(first + FRAMES_A_BLOCK, len(rows)) - 1
    first += first_frame
    others = len(wrong) - 1
    more = f" (and {others} more such block{'s' * (others > 1)})" if others else ""
    return f"frames {first} to {last}{more}"
