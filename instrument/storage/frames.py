"""What grows in a recording while it is written."""

import numpy as np

from instrument.storage import layout
from instrument.storage.checksum import Checksums
from instrument.storage.hdf5 import Growing
from instrument.storage.hdf5_file import File
from protocols import Floats


class OpenRecording:
    """The open file, and what grows in it."""

    def __init__(self, file: File, patterns_per_frame: int) -> None:
        """Take over a file that has everything in it; from now on others may read it."""
        self.file = file
        file.let_others_read()
        self.entry = file.at("entry")
        self.raw_counts = self.entry.rows(layout.RAW_COUNTS)
        self.raw_edges = self.entry.rows(layout.RAW_EDGE_TIME_S)
        self.values = Frames(self.entry.rows(layout.VALUES), Checksums(patterns_per_frame))
        self.edges = Frames(self.entry.rows(layout.EDGE_TIME_S), Checksums(patterns_per_frame))

    def note_length(self, file_bytes: int) -> None:
        """Write down how long the file is; 0 for one that is closed well."""
        self.entry.set_value(layout.FILE_BYTES, np.int64(file_bytes))


class Frames:
    """Values that come one after the other, stored in rows of one frame each; the rest of an open frame is NaN."""

    def __init__(self, dataset: Growing, checksums: Checksums) -> None:
        """Nothing has come yet."""
        self.dataset = dataset
        self.checksums = checksums
        self.whole = 0
        self.open_frame: Floats = np.empty(0)

    def append(self, values: Floats) -> None:
        """Write the next ones."""
        width = self.dataset.width
        pending = np.concatenate([self.open_frame, values])
        rows = -(-len(pending) // width)
        padded = np.full(rows * width, np.nan)
        padded[: len(pending)] = pending
        self.dataset.write(self.whole, padded.reshape(rows, width))
        self.checksums.add(values)
        done = len(pending) // width
        self.whole += done
        self.open_frame = pending[done * width :]

    @property
    def count(self) -> int:
        """Values so far."""
        return self.whole * self.dataset.width + len(self.open_frame)

    def __len__(self) -> int:
        """Frames so far, an open one included."""
        return len(self.dataset)
