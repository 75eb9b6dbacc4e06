"""Everything that a run hands over, in a plain file beside the recording, until the recording is closed.

HDF5 changes what it has written before: the indices of its datasets. A disk that loses its power keeps any part of what was not
synced, in any order, and with half an index HDF5 finds nothing at all, not even what was synced. A journal is only ever added
to, and each record carries a checksum: whatever the disk has lost, all records up to the last sync are there.

It is a spill file (``spill``) that begins with the recording as it was before its first block, so that ``recover`` makes the
recording anew from the journal alone. It is removed when the recording has been closed and synced.
"""

import os
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

import numpy as np

from instrument.storage.part import sync_folder
from instrument.storage.spill import EMPTY_RECORDING, FLAGS, Record, beside, head_of, stored_record


class Journal:
    """The journal of one run. It is written by one thread, and may be synced by another one."""

    def __init__(self, recording: Path, run: str, empty: bytes, records: Iterable[Record]) -> None:
        """Begin it with a first block, in one write: there is no journal without its beginning.

        Args:
            recording: where that is.
            run: which run it is, as ``run_of`` names it.
            empty: the recording as it was before its first block.
            records: the first block.

        Raises:
            OSError: it cannot be written.
        """
        self.path = beside(recording.resolve())
        """Where it is."""
        self._file = os.open(self.path, FLAGS, 0o600)
        padded = np.frombuffer(empty.ljust(-(-len(empty) // 8) * 8, b"\0"), "<f8")
        content = (head_of(run), stored_record(Record(EMPTY_RECORDING, 0, padded)), *map(stored_record, records))
        try:
            _write(self._file, b"".join(content))
            sync_folder(self.path.parent)
        except BaseException:
            self.remove()
            raise

    def add(self, records: Iterable[Record]) -> None:
        """Hand more to the system.

        Raises:
            OSError: it takes no more.
        """
        _write(self._file, b"".join(map(stored_record, records)))

    def sync(self, sync: Callable[[int], object]) -> None:
        """Make sure that what was added survives a power cut.

        Raises:
            OSError: the disk failed.
        """
        file = self._file
        if file >= 0:
            sync(file)

    def close(self) -> None:
        """Close it and leave it where it is; allowed twice."""
        file, self._file = self._file, -1
        if file >= 0:
            os.close(file)

    def remove(self) -> None:
        """Remove it: the recording is on the disk as a whole."""
        self.close()
        with suppress(OSError):
            self.path.unlink(missing_ok=True)


def _write(file: int, content: bytes) -> None:
    left = memoryview(content)
    while left:
        left = left[os.write(file, left) :]
