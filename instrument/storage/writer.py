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
from instrument.recording import STAGE_COLUMNS
from instrument.roles import ROLES, RoleName
from instrument.storage import layout, part
from instrument.storage.checksum import FRAMES_A_BLOCK, Checksums
from instrument.storage.failure import cut_off
from instrument.storage.hdf5 import File, Group, Growing
from instrument.storage.in_use import refuse_while_made, refuse_while_written
from instrument.storage.part import Part, remove_remains
from instrument.storage.place import cannot_be_written, refuse_existing, refuse_full_disk
from instrument.storage.provenance import PROGRAM, now, program_version
from instrument.storage.room import Room
from instrument.storage.spill import run_of
from protocols import CountBlock, DeviceIdentity, Floats, InputError, Mask, Truth

_ROWS_PER_CHUNK = 1024
_RAW_PER_CHUNK = 8192
_STAGE_ROWS = 64
_REPORT_BYTES: Final = 1 << 16
"""Room for the timing audit, which lists a thousand patterns of each kind at most."""
_REASON_BYTES: Final = 4096
"""Room for why a run ended early."""
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
            title: one line for people; by default the file's name.
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
        self.removed = tuple(remove_remains(path))
        """What programs that died had left beside it, and is removed."""
        try:
            self._part = Part(path.resolve(), "recorded")
        except OSError as error:
            raise cannot_be_written(path, error) from error
        try:
            refuse_while_made(path, but=self._part.path)  # another run may have begun at the same moment
            self._part.unlock()
            self._open, self.run = self._made(
                plan,
                {
                    layout.PICTURE_TIME_S: (picture_time_s, "s"),
                    layout.DEAD_TIME_S: (dead_time_s, "s"),
                    layout.DARK_RATE_HZ: (dark_rate_hz, "Hz"),
                },
                {"title": title or path.stem, layout.PLAN: plan.model_dump_json(), layout.BENCH: bench},
                devices or {},
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

    def _made(
        self,
        plan: Plan,
        figures: Mapping[str, tuple[float, str]],
        texts: Mapping[str, str],
        devices: Mapping[RoleName, DeviceIdentity],
        *,
        with_truth: bool,
    ) -> tuple["_Open", str]:
        """Make the file with all that is known now; give it, and the name of the run."""
        file = File(self._part.path, "w")
        try:
            entry = file.group("entry", "NXentry", default="data", complete=False)
            file.set_attributes(NX_class="NXroot", default="entry", file_name=self.path.name, creator=PROGRAM)
            entry.add_all(texts)
            run = _add_origin(entry, devices)
            for name, (figure, unit) in figures.items():
                entry.add(name, figure, units=unit)
            _add_what_grows(entry, self._patterns)
            _add_what_comes_last(entry, plan.image_size if with_truth else None)
            return _Open(file, self._patterns), run
        except BaseException:
            file.detach()
            file.close()
            raise

    def _in_place(self) -> "_Open":
        """Give the file in its place; the first time, put it there."""
        if not self._placed:
            if not part.RENAMES_OPEN_FILES:
                self._open.file.close()
            self._put_in_place()
            self._placed = True
            if not part.RENAMES_OPEN_FILES:
                self._open = _Open(File(self._part.path, "r+"), self._patterns)
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

    def sync(self) -> None:
        """Make sure that what was written survives a power cut. Any thread may call it, also during a write.

        Raises:
            OSError: the disk failed.
        """
        if self._part.fileno() >= 0:
            self._sync(self._part.fileno())
        else:  # Windows
            self.sync_other(self._part.path)

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
        entry.set_value(layout.INTERRUPTED, _cut(interrupted, _REASON_BYTES))
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


class _Open:
    """The open file, and what grows in it."""

    def __init__(self, file: File, patterns_per_frame: int) -> None:
        self.file = file
        file.let_others_read()
        self.entry = file.at("entry")
        self.raw_counts = self.entry.rows(layout.RAW_COUNTS)
        self.raw_edges = self.entry.rows(layout.RAW_EDGE_TIME_S)
        self.values = _Frames(self.entry.rows(layout.VALUES), Checksums(patterns_per_frame))
        self.edges = _Frames(self.entry.rows(layout.EDGE_TIME_S), Checksums(patterns_per_frame))

    def note_length(self, file_bytes: int) -> None:
        self.entry.set_value(layout.FILE_BYTES, np.int64(file_bytes))


class _Frames:
    """Values that come one after the other, stored in rows of one frame each; the rest of an open frame is NaN."""

    def __init__(self, dataset: Growing, checksums: Checksums) -> None:
        self.dataset = dataset
        self.checksums = checksums
        self.whole = 0
        self.open_frame: Floats = np.empty(0)

    def append(self, values: Floats) -> None:
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


def _cut(text: str, room_bytes: int) -> str:
    """``text``, without its end where it is too long."""
    encoded = text.encode()
    return text if len(encoded) <= room_bytes else encoded[: room_bytes - 3].decode(errors="ignore") + "..."


def _add_origin(entry: Group, devices: Mapping[RoleName, DeviceIdentity]) -> str:
    """Add who records when, and give the name of the run."""
    process, start_time = os.getpid(), now()
    entry.add("definition", layout.DEFINITION, version=layout.VERSION)
    entry.add(layout.PROGRAM_NAME, PROGRAM, version=program_version(), process_id=process)
    entry.add(layout.START_TIME, start_time)
    instrument = entry.group("instrument", "NXinstrument")
    groups = {role.name: instrument.group(role.name, role.nx_class) for role in ROLES}
    for name, identity in devices.items():
        groups[name].add_all(identity.model_dump())
    return run_of(start_time, process)


def _add_what_grows(entry: Group, patterns_per_frame: int) -> None:
    entry.add(layout.PHOTON_COUNTS, value=False)
    entry.growing(layout.RAW_COUNTS, (), _RAW_PER_CHUNK)
    entry.growing(layout.RAW_EDGE_TIME_S, (), _RAW_PER_CHUNK, units="s")
    entry.group("data", "NXdata", signal="values", axes=[".", "."])
    row = (patterns_per_frame,)
    rows = max(1, min(_ROWS_PER_CHUNK, _RAW_PER_CHUNK // patterns_per_frame))
    entry.growing(layout.VALUES, row, rows, long_name="light of each pattern, in play order")
    entry.growing(layout.EDGE_TIME_S, row, rows, units="s")


def _add_what_comes_last(entry: Group, truth_size: int | None) -> None:
    entry.add(layout.FILE_BYTES, np.zeros((), np.int64))
    entry.add_text_to_come(layout.END_TIME, len(now()))
    entry.add_text_to_come(layout.INTERRUPTED, _REASON_BYTES)
    what = "time from the start of the modulator (s), reported (mm), commanded (mm), 1 where predicted"
    entry.growing(layout.STAGE_POSITIONS, (STAGE_COLUMNS,), _STAGE_ROWS, long_name=what)
    entry.group("timing", "NXcollection")
    entry.add_numbers_to_come(layout.FRAME_VALID, _ROWS_PER_CHUNK, np.uint8)
    entry.add_text_to_come(layout.TIMING_REPORT, _REPORT_BYTES)
    entry.group("checksum", "NXcollection", algorithm="CRC-32", frames_per_block=FRAMES_A_BLOCK)
    for name in (layout.CHECKSUM_VALUES, layout.CHECKSUM_EDGES):
        entry.add_numbers_to_come(name, _ROWS_PER_CHUNK, np.uint32)
    if truth_size is not None:
        entry.group("truth", "NXcollection")
        entry.growing(layout.TRUTH_DISPLACEMENT_PX, (2,), _ROWS_PER_CHUNK, units="px")
        image = np.full((truth_size, truth_size), np.nan)
        entry.add(layout.TRUTH_IMAGE, image, long_name="transmission of the object at frame 0")
        background = "transmission of what stands still; without rows where there is nothing"
        entry.growing(layout.TRUTH_BACKGROUND, (truth_size,), truth_size, long_name=background)
