"""A recording written while it is measured.

The file is made early, with everything that is known before the run, under a temporary name beside its place
(``placed_file.PlacedFile``). It takes its place with the first block: until then an older recording stays, and a run that breaks
leaves nothing.

It is written in HDF5's single-writer-multiple-reader mode (SWMR), in which the library orders its writes so that the file can
be read at any moment, by a live display or after the program was killed; plain HDF5 promises nothing for a file that was not
closed. The price is that nothing can be *added* in that mode, so what is known only after the run has its place from the start,
empty, and is filled in at the end. From its first block on the file is never replaced: whoever reads it keeps it.
``/entry/@complete`` is the last thing that is written.

HDF5 cannot be trusted after a write that failed: a file that failed is left as it is (``abandon``). The writer itself knows no
threads: a run writes through ``keeper.Keeper``.
"""

import os
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from instrument.plan import Plan
from instrument.roles import RoleName
from instrument.storage import layout, part
from instrument.storage.empty_recording import empty_recording, fitting_reason
from instrument.storage.frames import OpenRecording
from instrument.storage.hdf5_file import File
from instrument.storage.part import alone_in, remove_remains
from instrument.storage.place import cannot_be_written, refuse_existing, refuse_full_disk
from instrument.storage.placed_file import PlacedFile
from instrument.storage.provenance import now
from protocols import CountBlock, DeviceIdentity, Floats, InputError, Mask, Truth


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
        self.picture_time_s = picture_time_s
        """Time from one pattern to the next."""
        self._patterns = plan.patterns_per_frame
        self._capacity = plan.frames * self._patterns
        refuse_full_disk(path, self._capacity)
        self._broken = False  # whether HDF5 did not come well out of a call
        self._counts_photons: bool | None = None
        with alone_in(path.resolve().parent):
            self.removed = tuple(remove_remains(path))
            """What programs that died had left beside it, and is removed."""
            self._file = PlacedFile(path, overwrite=overwrite, sync=sync)
            try:
                self._open, self.run = empty_recording(
                    self._file.lies_at,
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
                    name=path.name,
                    with_truth=with_truth,
                )
                """Which run it is, as its spill file names it."""
                self._file.take_room(0)
                self._file.let_others_read()
            except (OSError, RuntimeError) as error:  # HDF5 raises either for a disk that is full
                self._file.discard()
                raise cannot_be_written(path, error) from error
            except BaseException:
                self._file.discard()
                raise

    def _in_place(self) -> OpenRecording:
        """Give what is open, in its place; the first time, put it there."""
        if not self._file.placed:
            if not part.RENAMES_OPEN_FILES:
                self._open.file.close()
            self._file.put_in_place()
            if not part.RENAMES_OPEN_FILES:
                self._open = OpenRecording(File(self._file.lies_at, "r+"), self._patterns)
        return self._open

    @contextmanager
    def _writing(self) -> Generator[None]:
        """Take note where HDF5 fails, so that it is not called again."""
        try:
            yield
        except (OSError, RuntimeError):
            self._broken = True
            raise

    @property
    def path(self) -> Path:
        """Where the recording is, or will be."""
        return self._file.path

    @property
    def name_taken(self) -> InputError | None:
        """Set with the first block where another program has made a file of that name meanwhile: ``path`` is another one then."""
        return self._file.name_taken

    @property
    def is_open(self) -> bool:
        """Whether more can be written."""
        return self._open.file.is_open

    @property
    def frames(self) -> int:
        """Whole frames that whoever opens ``path`` finds there. Any thread may ask, also during a write."""
        return self._open.values.whole if self._file.placed else 0

    def content(self) -> bytes:
        """Give the file as it is now: before its first block, all that a journal needs to make it anew."""
        return self._file.lies_at.read_bytes()

    def sync(self) -> None:
        """Make sure that what was written survives a power cut. Any thread may call it, also during a write.

        Raises:
            OSError: the disk failed.
        """
        self._file.sync()

    @property
    def sync_by(self) -> Callable[[int], object]:
        """What makes a file of this run survive a power cut, by its descriptor."""
        return self._file.sync_by

    def sync_other(self, path: Path) -> None:
        """Make sure that another file of this run survives a power cut.

        Raises:
            OSError: the disk failed.
        """
        self._file.sync_other(path)

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
                self._file.give_room_back()
        try:
            if not self._file.placed and keep:
                self._file.placed = True
                self._file.put_in_place()
        finally:
            if self._file.placed:
                self._file.release()
            else:
                self._file.discard()

    def append_raw(self, block: CountBlock) -> None:
        """Store counts as they arrived, whatever the audit will make of them.

        The first block also tells whether the values are photon counts: uint32 counts are.
        """
        self._file.take_room(2 * len(block))
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
        self._file.take_room(2 * (len(values) + self._patterns))
        file = self._in_place()
        if file.values.count + len(values) > self._capacity:
            raise ValueError(f"{file.values.count + len(values)} values for the {self._capacity} patterns of the plan")
        with self._writing():
            # Edges first: a recording that breaks off here has no value without its time.
            file.edges.append(edges)
            file.values.append(values)
            self._open.note_length(self._file.note_length())

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
        self._file.take_room(4 * len(self._open.values))
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
        self._file.forget_length()
        self._file.give_room_back()
        self.sync()
        self.close()

    def discard(self) -> None:
        """Close the file and remove it: nothing at all was measured. An older recording stays."""
        self._open.file.close()
        self._file.discard()

    def close(self) -> None:
        """Close the file as it is, as a partial recording; allowed twice. One without a block is removed."""
        if not self._file.placed:
            self.discard()
        elif self._open.file.is_open:
            self._open.file.close()
            self._file.give_room_back()
        self._file.release()

    def __enter__(self) -> Self:
        """Give the open writer."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish a recording that is not finished as a partial one; remove it if nothing at all was measured."""
        if not self._open.file.is_open:
            self._file.release()
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
