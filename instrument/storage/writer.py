"""A recording written while it is measured.

The file is made early, with everything that is known before the run, under a temporary name beside its place (``part.Part``).
It takes its place with the first block: until then an older recording stays, and a run that breaks leaves nothing.

It is written in HDF5's single-writer-multiple-reader mode (SWMR), in which the library orders its writes so that the file can
be read at any moment, by a live display or after the program was killed; plain HDF5 promises nothing for a file that was not
closed. The price is that nothing can be *added* in that mode, so what is known only after the run has its place from the start,
empty, and is filled in at the end. From its first block on the file is never replaced: whoever reads it keeps it.
``/entry/@complete`` is the last thing that is written.

HDF5 cannot be trusted after a write that failed: it crashes, or never comes back. So room on the disk is taken before HDF5 needs
it (``room.Room``), a file that somebody has cut off is noticed before HDF5 meets it, and a file that failed all the same is left
as it is (``abandon``). The writer itself knows no threads: a run writes through ``keeper.Keeper``.
"""

import os
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Final, Self

import numpy as np

from instrument.plan import Plan
from instrument.roles import RoleName
from instrument.storage import layout, part
from instrument.storage.empty_recording import empty_recording, fitting_reason
from instrument.storage.failure import cut_off
from instrument.storage.frames import OpenRecording
from instrument.storage.hdf5_file import File
from instrument.storage.in_use import refuse_while_made, refuse_while_written
from instrument.storage.part import Part, alone_in, remove_remains
from instrument.storage.place import cannot_be_written, refuse_existing, refuse_full_disk
from instrument.storage.provenance import now
from instrument.storage.room import Room
from protocols import CountBlock, DeviceIdentity, Floats, InputError, Mask, Truth

_MOST_GROWTH: Final = 1 << 20
"""Most bytes by which HDF5 lengthens a file beside the numbers themselves: a chunk of each dataset, and their indices."""


class RecordingWriter:
    """Writes one recording. A context manager: leaving it with an error keeps what was measured and marks it as partial."""

    def __init__(
        self,
        path: Path,
        plan: Plan,
        *,
        picture_time_s: float,
        bench: str = "{}",
        devices: Mapping[RoleName, DeviceIdentity] | None = None,
        dead_time_s: float = 0.0,
        dark_rate_hz: float = 0.0,
        title: str = "",
        with_truth: bool = False,
        overwrite: bool = False,
        sync: Callable[[int], object] = os.fsync,
    ) -> None:
        """Make the file under a temporary name; it takes its place with the first block.

        Args:
            path: where to; a link to a file stays one.
            plan: what was asked for.
            picture_time_s: time from one pattern to the next, as read back from the modulator.
            bench: the resolved bench as JSON.
            devices: identity of each device.
            dead_time_s: non-paralyzable dead time of detector and counter.
            dark_rate_hz: dark counts a second.
            title: one line for people; by default that of the plan, or the file's name.
            with_truth: whether ``finish`` will be given a truth, as for simulated runs.
            overwrite: whether an existing recording may be lost.
            sync: makes a file survive a power cut, by its descriptor.

        Raises:
            InputError: ``path`` exists and may not be overwritten, is being recorded, cannot be created, or has too little room.
        """
        refuse_existing(path, overwrite=overwrite)
        self.path = path
        """Where the recording is, or will be."""
        self.picture_time_s = picture_time_s
        """Time from one pattern to the next."""
        self._patterns = plan.patterns_per_frame
        self._capacity = plan.frames * self._patterns
        refuse_full_disk(path, self._capacity)
        self._overwrite = overwrite
        self._sync = sync
        self._broken = False  # whether HDF5 did not come well out of a call
        self._length = 0
        self._counts_photons: bool | None = None
        self._placed = False
        self.name_taken: InputError | None = None
        """Set with the first block where another program has made a file of that name meanwhile: ``path`` is another one then."""
        with alone_in(path.resolve().parent):
            self.removed = tuple(remove_remains(path))
            """What programs that died had left beside it, and is removed."""
            self._part = _claimed(path)
            try:
                self._part.unlock()
                self._open, self.run = empty_recording(
                    self._part.path,
                    plan,
                    {
                        layout.PICTURE_TIME_S: (picture_time_s, "s"),
                        layout.DEAD_TIME_S: (dead_time_s, "s"),
                        layout.DARK_RATE_HZ: (dark_rate_hz, "Hz"),
                    },
                    {
                        "title": title or _title(plan) or path.stem,
                        layout.PLAN: plan.model_dump_json(),
                        layout.BENCH: bench,
                    },
                    devices or {},
                    name=self.path.name,
                    with_truth=with_truth,
                )
                """Which run it is, as its spill file names it."""
                self._room = Room(self._part.path, self._part.fileno())
                self._take_room(0)
                self._part.let_others_read()
            except (OSError, RuntimeError) as error:  # HDF5 raises either for a disk that is full
                self._part.discard()
                raise cannot_be_written(path, error) from error
            except BaseException:
                self._part.discard()
                raise

    def _in_place(self) -> OpenRecording:
        """Give the file in its place; the first time, put it there."""
        if not self._placed:
            if not part.RENAMES_OPEN_FILES:
                self._open.file.close()
            self._put_in_place()
            self._placed = True
            if not part.RENAMES_OPEN_FILES:
                self._open = OpenRecording(File(self._part.path, "r+"), self._patterns)
        return self._open

    def _take_room(self, numbers: int) -> None:
        """Make sure that HDF5 can write so many more numbers, before it begins.

        Raises:
            OSError: there is no room.
            StorageFailed: the file has lost its end.
        """
        if self._part.fileno() < 0:  # Windows: nobody else may write it
            return
        size = os.fstat(self._part.fileno()).st_size
        if size < self._length or self._room.lost():
            raise cut_off(self.path, size)
        self._room.take(size + 8 * numbers + _MOST_GROWTH)

    @contextmanager
    def _writing(self) -> Generator[None]:
        """Take note where HDF5 fails, so that it is not called again."""
        try:
            yield
        except (OSError, RuntimeError):
            self._broken = True
            raise

    def _give_room_back(self) -> None:
        """Give back what was taken beyond the end of the file."""
        if self._part.fileno() >= 0:
            self._room.give_back()

    def _note_length(self) -> None:
        """Write down how long the file is, for whoever reads it after this program was killed."""
        self._length = self._part.path.stat().st_size
        self._open.note_length(self._length)

    @property
    def is_open(self) -> bool:
        """Whether more can be written."""
        return self._open.file.is_open

    @property
    def frames(self) -> int:
        """Whole frames that whoever opens ``path`` finds there. Any thread may ask, also during a write."""
        return self._open.values.whole if self._placed else 0

    def content(self) -> bytes:
        """Give the file as it is now: before its first block, all that a journal needs to make it anew."""
        return self._part.path.read_bytes()

    def sync(self) -> None:
        """Make sure that what was written survives a power cut. Any thread may call it, also during a write.

        Raises:
            OSError: the disk failed.
        """
        if self._part.fileno() >= 0:
            self._sync(self._part.fileno())
        else:  # Windows
            self.sync_other(self._part.path)

    @property
    def sync_by(self) -> Callable[[int], object]:
        """What makes a file of this run survive a power cut, by its descriptor."""
        return self._sync

    def sync_other(self, path: Path) -> None:
        """Make sure that another file of this run survives a power cut.

        Raises:
            OSError: the disk failed.
        """
        with path.open("rb+") as file:
            self._sync(file.fileno())

    def abandon(self, *, hangs: bool = False, keep: bool = True) -> None:
        """Leave a file that failed as it is. HDF5 touches it no more, neither now nor at the end of the process.

        Args:
            hangs: whether HDF5 has not come back from a call, so that it cannot be called again at all.
            keep: whether the file is kept; without, it is removed if it has not taken its place.

        Raises:
            OSError: a file without a block cannot be put in its place, where it is looked for together with its spilled counts.
        """
        self._open.file.detach()
        if self._broken or hangs:
            self._open.file.leave_open()
        else:
            with suppress(OSError, RuntimeError):
                self._open.file.close()
        if not hangs:
            with suppress(OSError):
                self._give_room_back()
        try:
            if not self._placed and keep:
                self._placed = True
                self._put_in_place()
        finally:
            if self._placed:
                self._part.release()
            else:
                self._part.discard()

    def _put_in_place(self) -> None:
        try:
            if self._overwrite:
                refuse_while_written(self.path, but=self._part.path)
            self._part.put_in_place(replace=self._overwrite)
        except (FileExistsError, InputError) as error:
            # The counts are there: they are kept, and the run is told when they are.
            self.path, asked = self._part.put_beside(), self.path
            self.name_taken = InputError(
                saw=f"{asked}, which another program has made since the run began ({error})",
                expected="a place that nobody else writes to",
                remedy=f"what was counted is in {self.path}; name another file for the next run",
            )

    def append_raw(self, block: CountBlock) -> None:
        """Store counts as they arrived, whatever the audit will make of them.

        The first block also tells whether the values are photon counts: uint32 counts are.
        """
        self._take_room(2 * len(block))
        file = self._in_place()
        if self._counts_photons is None and len(block):
            self._counts_photons = block.photon_counts
            file.entry.set_value(layout.PHOTON_COUNTS, self._counts_photons)
        edges = np.full(len(block), np.nan) if block.opening_edge_s is None else block.opening_edge_s
        with self._writing():
            first = len(file.raw_counts)
            file.raw_edges.write(first, edges)
            file.raw_counts.write(first, block.counts.astype(np.float64))

    def append(self, values: Floats, edge_time_s: Floats | None = None) -> None:
        """Store the next values, in whole frames or parts of frames. They are on their way to the disk on return.

        Args:
            values: ``(n,)`` in play order; NaN where no value was measured.
            edge_time_s: ``(n,)`` opening edges from the first one on; None without edge times.

        Raises:
            ValueError: more values than the plan has patterns, or not one edge time a value.
        """
        edges = np.full(len(values), np.nan) if edge_time_s is None else edge_time_s
        if len(edges) != len(values):
            raise ValueError(f"{len(edges)} edge times for {len(values)} values")
        self._take_room(2 * (len(values) + self._patterns))
        file = self._in_place()
        if file.values.count + len(values) > self._capacity:
            raise ValueError(f"{file.values.count + len(values)} values for the {self._capacity} patterns of the plan")
        with self._writing():
            # Edges first: a recording that breaks off here has no value without its time.
            file.edges.append(edges)
            file.values.append(values)
            self._note_length()

    def finish(
        self,
        *,
        frame_valid: Mask | None = None,
        report: str = "{}",
        truth: Truth | None = None,
        stage: Floats | None = None,
        interrupted: str = "",
    ) -> None:
        """Fill in what is known only after the run, and close the file. Whoever reads it meanwhile keeps it.

        Args:
            frame_valid: ``(frames,)``; by default the frames in which every pattern has a value.
            report: the timing audit as JSON.
            truth: simulated runs only: what really was there, ``(frames, 2)`` and the image.
            stage: ``(n, 4)`` where the stage was, as ``StageLog.rows``.
            interrupted: why the run ended early, which makes it a partial recording; empty for a run that came to its end.

        Raises:
            ValueError: a mask that is not one flag a frame, a truth that was not announced or has another size, or a report
                that is too long.
        """
        self._take_room(4 * len(self._open.values))
        file = self._in_place()
        frames = len(file.values)
        if frame_valid is not None and frame_valid.shape != (frames,):
            raise ValueError(f"frame_valid of shape {frame_valid.shape} for {frames} frames")
        entry = file.entry
        if truth is not None:
            if layout.TRUTH_IMAGE not in entry:
                raise ValueError("a truth for a recording that was opened without one")
            entry.set_value(layout.TRUTH_IMAGE, truth.image)
            entry.rows(layout.TRUTH_DISPLACEMENT_PX).write(0, truth.displacement_px)
            if truth.background is not None:
                entry.rows(layout.TRUTH_BACKGROUND).write(0, truth.background)
        if stage is not None:
            entry.rows(layout.STAGE_POSITIONS).write(0, stage)
        entry.set_value(layout.TIMING_REPORT, report)
        valid = layout.measured_frames(file.values.dataset.read()) if frame_valid is None else frame_valid
        entry.rows(layout.FRAME_VALID).write(0, valid.astype(np.uint8))
        entry.rows(layout.CHECKSUM_EDGES).write(0, file.edges.checksums.finished())
        entry.rows(layout.CHECKSUM_VALUES).write(0, file.values.checksums.finished())
        entry.set_value(layout.INTERRUPTED, fitting_reason(interrupted))
        entry.set_value(layout.END_TIME, now())
        file.note_length(0)  # HDF5 knows the length of a file that was closed
        entry.set_attribute("complete", not interrupted)
        self._open.file.close()
        self._length = 0
        self._give_room_back()
        self.sync()
        self.close()

    def discard(self) -> None:
        """Close the file and remove it: nothing at all was measured. An older recording stays."""
        self._open.file.close()
        self._part.discard()

    def close(self) -> None:
        """Close the file as it is, as a partial recording; allowed twice. One without a block is removed."""
        if not self._placed:
            self.discard()
        elif self._open.file.is_open:
            self._open.file.close()
            self._give_room_back()
        self._part.release()

    def __enter__(self) -> Self:
        """Give the open writer."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish a recording that is not finished as a partial one; remove it if nothing at all was measured."""
        if not self._open.file.is_open:
            self._part.release()
            return
        if not len(self._open.raw_counts) and not self._open.values.count:
            self.discard()
            return
        if self._broken:
            self.abandon()
            return
        try:
            self.finish(interrupted=str(error) or type(error).__name__ if error else "never finished")
        except Exception as failure:
            self.abandon()
            # The first error is what matters, and the counts are in the file already.
            if error is None:
                raise
            error.add_note(f"{self.path} holds what was measured, but could not be closed well: {failure}")


def _title(plan: Plan) -> str:
    return "" if plan.run is None else plan.run.title


def _claimed(path: Path) -> Part:
    """Create the file under its temporary name, unless another run makes ``path`` already.

    Raises:
        InputError: names the other run, or it cannot be created.
    """
    try:
        made = Part(path.resolve(), "recorded")
    except OSError as error:
        raise cannot_be_written(path, error) from error
    try:
        refuse_while_made(path, but=made.path)  # another run may have begun since that was asked
    except BaseException:
        made.discard()
        raise
    return made
