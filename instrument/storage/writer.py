"""A recording written while it is measured.

The file is opened early, with everything that is known before the run, and switched to HDF5's single-writer-multiple-reader
mode (SWMR). In that mode the library orders its writes so that the file can be read at any moment, by a live display or after
the program was killed; plain HDF5 promises nothing for a file that was not closed. The price is that nothing can be *added* in
that mode, so what is known only after the run has its place from the start, empty, and is filled in at the end. The file is
never replaced: whoever reads it keeps it. ``/entry/@complete`` is the last thing that is written.
"""

import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Final, Self

import numpy as np

from instrument.plan import Plan
from instrument.roles import ROLES, RoleName
from instrument.storage import layout
from instrument.storage.hdf5 import File, Group, Growing, is_hdf5
from instrument.storage.in_use import WritersMark
from instrument.storage.provenance import PROGRAM, now, program_version
from protocols import CountBlock, DeviceIdentity, Floats, InputError, Mask, Truth

_ROWS_PER_CHUNK = 1024
_RAW_PER_CHUNK = 8192
_BYTES_A_PATTERN = 4 * 8
"""Value, edge time, and both again as they arrived."""
_BYTES_BESIDE = 1 << 20
"""Room for everything else."""
_REPORT_BYTES: Final = 1 << 16
"""Room for the timing audit, which lists a thousand patterns of each kind at most."""
_REASON_BYTES: Final = 4096
"""Room for why a run ended early."""


def refuse_existing(path: Path, *, overwrite: bool = False) -> None:
    """Make sure that a recording may be written to ``path``; to be asked before anything moves.

    Raises:
        InputError: the file exists and ``overwrite`` is not set, it is something else than an HDF5 file, or its folder is
            missing.
    """
    if not path.parent.is_dir():
        raise InputError(
            saw=f"no folder {path.parent}",
            expected="an existing folder for the recording",
            remedy="make the folder, or name another one",
        )
    if not path.exists():
        return
    if not overwrite:
        raise InputError(
            saw=f"{path}, which exists",
            expected="the name of a new file",
            remedy="name another file, or give --overwrite to lose the old one",
        )
    if not path.is_file() or not is_hdf5(path):
        raise InputError(
            saw=f"{path}, which is no HDF5 file",
            expected="a recording to overwrite",
            remedy="name another file; if this one is really to go, remove it by hand",
        )


def refuse_full_disk(path: Path, patterns: int) -> None:
    """Make sure that there is room for a recording: HDF5 gives up without grace on a full disk.

    Raises:
        InputError: there is less than the recording, and its copy when an analysis is stored, take.
    """
    needed = 2 * patterns * _BYTES_A_PATTERN + _BYTES_BESIDE
    free = shutil.disk_usage(path.parent).free
    if free < needed:
        raise InputError(
            saw=f"{free / 1e6:.1f} MB free for {path}",
            expected=f"{needed / 1e6:.1f} MB for {patterns} patterns",
            remedy="make room on the disk, or name another folder",
        )


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
    ) -> None:
        """Create the file.

        Args:
            path: where to.
            plan: what was asked for.
            picture_time_s: time from one pattern to the next, as read back from the modulator.
            bench: the resolved bench as JSON.
            devices: identity of each device.
            dead_time_s: non-paralyzable dead time of detector and counter.
            dark_rate_hz: dark counts a second.
            title: one line for people; by default the file's name.
            with_truth: whether ``finish`` will be given a truth, as for simulated runs.
            overwrite: whether an existing recording may be lost.

        Raises:
            InputError: ``path`` exists and may not be overwritten, cannot be created, or has too little room.
        """
        refuse_existing(path, overwrite=overwrite)
        self.path = path
        """Where the recording is."""
        self.picture_time_s = picture_time_s
        """Time from one pattern to the next."""
        self._patterns = plan.patterns_per_frame
        self._capacity = plan.frames * self._patterns
        refuse_full_disk(path, self._capacity)
        self._counts_photons: bool | None = None
        try:
            self._file = File(path, "w")
        except OSError as error:
            raise InputError(
                saw=f"{path}, which cannot be written: {error}",
                expected="a place for the recording",
                remedy="close the program that holds the file, or name another file",
            ) from error
        self._file.set_attributes(NX_class="NXroot", default="entry", file_name=path.name, creator=PROGRAM)
        entry = self._file.group("entry", "NXentry", default="data", complete=False)
        entry.add("title", title or path.stem)
        entry.add("definition", layout.DEFINITION, version=layout.VERSION)
        entry.add(layout.PROGRAM_NAME, PROGRAM, version=program_version(), process_id=os.getpid())
        entry.add(layout.START_TIME, now())
        entry.add(layout.PLAN, plan.model_dump_json())
        entry.add(layout.BENCH, bench)
        instrument = entry.group("instrument", "NXinstrument")
        groups = {role.name: instrument.group(role.name, role.nx_class) for role in ROLES}
        for name, identity in (devices or {}).items():
            groups[name].add_all(identity.model_dump())
        entry.add(layout.PICTURE_TIME_S, picture_time_s, units="s")
        entry.add(layout.DEAD_TIME_S, dead_time_s, units="s")
        entry.add(layout.DARK_RATE_HZ, dark_rate_hz, units="Hz")
        entry.add(layout.PHOTON_COUNTS, value=False)
        self._raw_counts = entry.growing(layout.RAW_COUNTS, (), _RAW_PER_CHUNK)
        self._raw_edges = entry.growing(layout.RAW_EDGE_TIME_S, (), _RAW_PER_CHUNK, units="s")
        entry.group("data", "NXdata", signal="values", axes=[".", "."])
        row = (self._patterns,)
        self._values = _Frames(
            entry.growing(layout.VALUES, row, _ROWS_PER_CHUNK, long_name="light of each pattern, in play order")
        )
        self._edges = _Frames(entry.growing(layout.EDGE_TIME_S, row, _ROWS_PER_CHUNK, units="s"))
        self._add_what_comes_last(entry, plan.image_size if with_truth else None)
        self._file.let_others_read()
        self._mark = WritersMark(path)

    def _add_what_comes_last(self, entry: Group, truth_size: int | None) -> None:
        entry.add(layout.FILE_BYTES, np.zeros((), np.int64))
        entry.add_text_to_come(layout.END_TIME, len(now()))
        entry.add_text_to_come(layout.INTERRUPTED, _REASON_BYTES)
        timing = entry.group("timing", "NXcollection")
        self._frame_valid = timing.add_flags_to_come("frame_valid", _ROWS_PER_CHUNK)
        timing.add_text_to_come("report", _REPORT_BYTES)
        self._truth_px: Growing | None = None
        if truth_size is not None:
            truth = entry.group("truth", "NXcollection")
            self._truth_px = truth.growing("displacement_px", (2,), _ROWS_PER_CHUNK, units="px")
            image = np.full((truth_size, truth_size), np.nan)
            truth.add("image", image, long_name="transmission of the object at frame 0")

    def append_raw(self, block: CountBlock) -> None:
        """Store counts as they arrived, whatever the audit will make of them.

        The first block also tells whether the values are photon counts: uint32 counts are.
        """
        if self._counts_photons is None and len(block):
            self._counts_photons = block.photon_counts
            self._file.set_value(f"entry/{layout.PHOTON_COUNTS}", self._counts_photons)
        edges = np.full(len(block), np.nan) if block.opening_edge_s is None else block.opening_edge_s
        first = len(self._raw_counts)
        self._raw_edges.write(first, edges)
        self._raw_counts.write(first, block.counts.astype(np.float64))

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
        if self._values.count + len(values) > self._capacity:
            raise ValueError(f"{self._values.count + len(values)} values for the {self._capacity} patterns of the plan")
        # Edges first: a recording that breaks off here has no value without its time.
        self._edges.append(edges)
        self._values.append(values)
        self._note_length(self.path.stat().st_size)

    def _note_length(self, file_bytes: int) -> None:
        self._file.set_value(f"entry/{layout.FILE_BYTES}", np.int64(file_bytes))

    def finish(
        self,
        *,
        frame_valid: Mask | None = None,
        report: str = "{}",
        truth: Truth | None = None,
        interrupted: str = "",
    ) -> None:
        """Fill in what is known only after the run, and close the file. Whoever reads it meanwhile keeps it.

        Args:
            frame_valid: ``(frames,)``; by default the frames in which every pattern has a value.
            report: the timing audit as JSON.
            truth: simulated runs only: what really was there, ``(frames, 2)`` and the image.
            interrupted: why the run ended early, which makes it a partial recording; empty for a run that came to its end.

        Raises:
            ValueError: a mask that is not one flag a frame, a truth that was not announced or has another size, or a report
                that is too long.
        """
        frames = len(self._values)
        if frame_valid is not None and frame_valid.shape != (frames,):
            raise ValueError(f"frame_valid of shape {frame_valid.shape} for {frames} frames")
        entry = self._file.at("entry")
        if truth is not None:
            if self._truth_px is None:
                raise ValueError("a truth for a recording that was opened without one")
            entry.set_value(layout.TRUTH_IMAGE, truth.image)
            self._truth_px.write(0, truth.displacement_px)
        entry.set_value(layout.TIMING_REPORT, report)
        valid = layout.measured_frames(self._values.dataset.read()) if frame_valid is None else frame_valid
        self._frame_valid.write(0, valid.astype(np.uint8))
        entry.set_value(layout.INTERRUPTED, _cut(interrupted, _REASON_BYTES))
        entry.set_value(layout.END_TIME, now())
        self._note_length(0)  # HDF5 knows the length of a file that was closed
        entry.set_attribute("complete", not interrupted)
        self.close()
        with self.path.open("rb+") as written:
            os.fsync(written.fileno())

    def discard(self) -> None:
        """Close the file and remove it: nothing at all was measured."""
        self.close()
        self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Close the file as it is, as a partial recording; allowed twice."""
        self._file.close()
        self._mark.release()

    def __enter__(self) -> Self:
        """Give the open writer."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish a recording that is not finished as a partial one; remove it if nothing at all was measured."""
        if not self._file.is_open:
            return
        if not len(self._raw_counts) and not self._values.count:
            self.discard()
            return
        try:
            self.finish(interrupted=str(error) or type(error).__name__ if error else "never finished")
        except Exception as failure:
            self.close()
            # The first error is what matters, and the counts are in the file already.
            if error is None:
                raise
            error.add_note(f"{self.path} holds what was measured, but could not be closed well: {failure}")


class _Frames:
    """Values that come one after the other, stored in rows of one frame each; the rest of an open frame is NaN."""

    def __init__(self, dataset: Growing) -> None:
        self.dataset = dataset
        self.whole = 0
        self.open_frame: Floats = np.empty(0)

    def append(self, values: Floats) -> None:
        width = self.dataset.width
        pending = np.concatenate([self.open_frame, values])
        rows = -(-len(pending) // width)
        padded = np.full(rows * width, np.nan)
        padded[: len(pending)] = pending
        self.dataset.write(self.whole, padded.reshape(rows, width))
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
