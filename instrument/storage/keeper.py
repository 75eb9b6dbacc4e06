"""Between a run and the disk: blocks are written and made durable on threads of their own, so that a slow disk delays nobody.

The run hands over each block and goes on. One thread writes the blocks into the recording, another one makes the file survive a
power cut (``fsync``) every half second. A block is held in memory until both have been done. If the disk refuses, or does not
answer for ``PATIENCE_S``, the run is told, and ends; HDF5 is not called again then, and every block still held, which is all
that may not be on the disk, goes to a spill file.
"""

import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from threading import Condition, Thread
from typing import Final

import numpy as np

from instrument.storage import layout
from instrument.storage.failure import StorageFailed, failed, no_answer
from instrument.storage.hdf5 import note_that_hdf5_hangs
from instrument.storage.spill import Record, places_for, write_spill
from instrument.storage.writer import RecordingWriter
from protocols import CountBlock, Floats, Mask, Truth

SYNC_S: Final = 0.5
"""Time from one ``fsync`` to the next: a power cut loses no more than that, and what one ``fsync`` takes."""

PATIENCE_S: Final = 2.5
"""So long the disk may take for one block, or for one ``fsync``, before the run ends."""

MOST_BYTES: Final = 64 << 20
"""Counts that may be held in memory: three minutes at 20 kHz. A run on virtual time waits for the disk there."""

_SPILL_S: Final = 0.5
"""So long a place may take to be spilled to, before the next one is tried."""


@dataclass(frozen=True, eq=False)
class _Piece:
    """What one call of the writer stores."""

    write: Callable[[RecordingWriter], object]
    records: tuple[Record, ...]
    """The same for a spill file."""

    @property
    def held_bytes(self) -> int:
        return 8 * sum(len(record.numbers) for record in self.records)


@dataclass(frozen=True)
class Rescue:
    """What became of a recording that the disk did not take."""

    error: StorageFailed
    """Why."""

    kept_until: int
    """Patterns that were on the disk, in the recording."""

    spill: Path | None
    """File with what came after them; None where there was nothing more, or where it could be written nowhere."""

    doubt: str = ""
    """Why that file may not survive a power cut; empty where it does."""

    lost: str = ""
    """Why what came after could be written nowhere; empty where it was, or had not to be."""


def made_in_time(path: Path, make: Callable[[], RecordingWriter], patience_s: float = PATIENCE_S) -> RecordingWriter:
    """Make a writer on a thread of its own, as the disk may hang there too.

    Raises:
        StorageFailed: the disk does not answer.
        InputError: as ``RecordingWriter``.
    """
    made: list[RecordingWriter | BaseException] = []

    def work() -> None:
        try:
            made.append(make())
        except BaseException as error:  # noqa: BLE001 - it is raised below
            made.append(error)

    thread = Thread(target=work, name="kinopix-maker", daemon=True)
    thread.start()
    thread.join(patience_s)
    if not made:
        note_that_hdf5_hangs(thread)
        raise no_answer(path, patience_s)
    if isinstance(made[0], BaseException):
        raise made[0]
    return made[0]


class Keeper:
    """Keeps what a run counts. The run's thread calls it; only ``finish`` and ``discard`` wait for the disk."""

    def __init__(
        self,
        writer: RecordingWriter,
        *,
        patience_s: float = PATIENCE_S,
        most_bytes: int = MOST_BYTES,
    ) -> None:
        """Start both threads.

        Args:
            writer: open, and from now on called by the threads alone.
            patience_s: so long the disk may take for one call.
            most_bytes: numbers that may be held in memory.
        """
        self.writer = writer
        """Where to. To be looked at, not to be called."""
        self._patience_s = patience_s
        self._most_bytes = most_bytes
        self._raw = self._patterns = 0
        self._waiting: deque[_Piece] = deque()  # not written, or being written
        self._unsynced: deque[_Piece] = deque()  # written, not durable
        self._held_bytes = 0
        self._begun: dict[str, float] = {}  # calls of the disk that go on, with their beginnings
        self._error: StorageFailed | None = None
        self._ending = False
        self._changed = Condition()
        # Daemons: a disk that does not answer must not keep the program from ending.
        self._threads = [
            Thread(target=work, name=f"kinopix-{name}", daemon=True)
            for name, work in (("writer", self._write), ("sync", self._make_durable))
        ]
        for thread in self._threads:
            thread.start()

    def raw(self, block: CountBlock) -> None:
        """Take a block as the counter gave it.

        Raises:
            StorageFailed: the disk does not take what came before. The block is held all the same.
        """
        edges = np.full(len(block), np.nan) if block.opening_edge_s is None else block.opening_edge_s
        records = (
            Record(layout.RAW_EDGE_TIME_S, self._raw, edges.copy()),
            Record(layout.RAW_COUNTS, self._raw, block.counts.astype(np.float64)),
            Record(layout.PHOTON_COUNTS, 0, np.full(1, float(block.photon_counts))),
        )
        self._raw += len(block)
        opening_edge_s = None if block.opening_edge_s is None else records[0].numbers
        mine = replace(
            block, counts=block.counts.copy(), opening_edge_s=opening_edge_s
        )  # its buffers may be used again
        self._put(_Piece(lambda writer: writer.append_raw(mine), records))

    def placed(self, values: Floats, edge_time_s: Floats | None) -> None:
        """Take the values of the next patterns, ``(n,)`` each, as ``RecordingWriter.append``.

        Raises:
            StorageFailed: the disk does not take what came before. The values are held all the same.
        """
        edges = np.full(len(values), np.nan) if edge_time_s is None else edge_time_s
        records = (
            Record(layout.EDGE_TIME_S, self._patterns, edges.copy()),
            Record(layout.VALUES, self._patterns, values.copy()),
        )
        self._patterns += len(values)
        self._put(_Piece(lambda writer: writer.append(records[1].numbers, records[0].numbers), records))

    def check(self) -> None:
        """Find out whether the disk takes what it is given.

        Raises:
            StorageFailed: it does not.
        """
        with self._changed:
            self._raise()

    def finish(
        self,
        *,
        frame_valid: Mask,
        report: str,
        truth: Truth | None = None,
        stage: Floats | None = None,
        interrupted: str = "",
    ) -> Rescue | None:
        """Write what is left and close the recording, as ``RecordingWriter.finish``.

        Returns:
            None for a recording that is on the disk as a whole.
        """
        numbers = {layout.FRAME_VALID: frame_valid.astype(np.float64)}
        if truth is not None:
            numbers |= {layout.TRUTH_DISPLACEMENT_PX: truth.displacement_px, layout.TRUTH_IMAGE: truth.image}
        texts = {layout.TIMING_REPORT: report, layout.INTERRUPTED: interrupted}
        records = (
            *(Record(what, 0, array.ravel()) for what, array in numbers.items()),
            *(Record(what, 0, np.empty(0), text) for what, text in texts.items() if text),
        )

        def write(writer: RecordingWriter) -> None:
            writer.finish(frame_valid=frame_valid, report=report, truth=truth, stage=stage, interrupted=interrupted)

        with suppress(StorageFailed):
            self._put(_Piece(write, records))
        self._end()
        return None if self._error is None else self._rescued(self._error)

    def discard(self) -> None:
        """Remove the recording: nothing was measured."""
        self._end()
        if self._error is None:
            self.writer.discard()
        else:
            self.writer.abandon(hangs="write" in self._begun, keep=False)

    def _put(self, piece: _Piece) -> None:
        with self._changed:
            self._waiting.append(piece)
            self._held_bytes += piece.held_bytes
            self._changed.notify_all()
            self._raise()
            while self._held_bytes > self._most_bytes:
                self._changed.wait(self._patience_s / 10)
                self._raise()

    def _raise(self) -> None:
        """Raise what failed, or a call of the disk that goes on for too long."""
        now_s = time.monotonic()
        late_s = max((now_s - begun_s for begun_s in self._begun.values()), default=0.0)
        if self._error is None and late_s > self._patience_s:
            self._error = no_answer(self.writer.path, late_s)
            self._changed.notify_all()
        if self._error is not None:
            raise self._error

    def _end(self) -> None:
        """Wait until everything is written, or nothing can be written any more."""
        with self._changed, suppress(StorageFailed):
            self._ending = True
            self._changed.notify_all()
            while self._waiting or self._begun:
                self._raise()
                self._changed.wait(self._patience_s / 10)

    def _write(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._ending or self._error)
                if self._error is not None or not self._waiting:
                    return
                piece = self._waiting[0]
                self._begun["write"] = time.monotonic()
            if not self._done("write", partial(piece.write, self.writer)):
                return
            with self._changed:
                self._unsynced.append(self._waiting.popleft())
                del self._begun["write"]
                self._changed.notify_all()

    def _make_durable(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(self._sync_is_due, SYNC_S)
                if self._error is not None or self._ending:
                    return
                count = len(self._unsynced)
                if not count:
                    continue
                self._begun["sync"] = time.monotonic()
            if not self._done("sync", self.writer.sync):
                return
            with self._changed:
                for _ in range(count):
                    self._held_bytes -= self._unsynced.popleft().held_bytes
                del self._begun["sync"]
                self._changed.notify_all()

    def _sync_is_due(self) -> bool:
        crowded = self._held_bytes > self._most_bytes // 2 and bool(self._unsynced)
        return crowded or self._ending or self._error is not None

    def _done(self, call: str, work: Callable[[], object]) -> bool:
        """Do one thing with the disk, and tell whether it went well; if not, the run is told."""
        try:
            work()
        except BaseException as error:  # noqa: BLE001 - whatever HDF5 or the system raises, the counts must be saved
            with self._changed:
                self._begun.pop(call)
                self._error = self._error or failed(self.writer.path, error)
                self._changed.notify_all()
            return False
        return True

    def _rescued(self, error: StorageFailed) -> Rescue:
        """Leave the recording as it is, and save what may not be in it."""
        lost = ""
        error.hangs = error.hangs or "write" in self._begun
        try:
            self.writer.abandon(hangs="write" in self._begun)
        except OSError as left:
            lost = f"{self.writer.path} could not be put in its place ({left})"
        with self._changed:
            records = [record for piece in (*self._unsynced, *self._waiting) for record in piece.records]
        kept = min((record.first for record in records if record.what == layout.VALUES), default=self._patterns)
        if not records:
            return Rescue(error, kept, None, lost=lost)
        return self._spilled(Rescue(error, kept, None), records)

    def _spilled(self, rescue: Rescue, records: list[Record]) -> Rescue:
        """Spill to the first place that takes it for good, or else to the first one that takes it at all."""
        refused: list[str] = []
        doubtful: list[tuple[Path, str]] = []
        for place in places_for(self.writer.path):
            written, why = self._try(place, records)
            if not why:
                for other, _ in doubtful:
                    other.unlink(missing_ok=True)
                return replace(rescue, spill=place)
            if written:
                doubtful.append((place, why))
            refused.append(f"{place.parent}: {why}")
        for other, _ in doubtful[1:]:
            other.unlink(missing_ok=True)
        if doubtful:
            place, why = doubtful[0]
            return replace(rescue, spill=place, doubt=why)
        return replace(rescue, lost="; ".join(refused))

    def _try(self, place: Path, records: list[Record]) -> tuple[bool, str]:
        """Spill to a place within ``_SPILL_S``; give whether the file is whole, and why it may not last."""
        written: list[bool] = []
        said: list[str] = []

        def spill() -> None:
            try:
                write_spill(place, self.writer.run, records)
                written.append(True)
                self.writer.sync_other(place)
            except OSError as error:
                said.append(str(error))
            else:
                said.append("")

        thread = Thread(target=spill, name="kinopix-spill", daemon=True)
        thread.start()
        thread.join(_SPILL_S)
        return bool(written), said[0] if said else f"no answer for {_SPILL_S:g} s"
