"""A recording read back: whole, partial, or left behind by a program that was killed."""

import json
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from instrument.config import NOTHING_KNOWN, Calibration, LightTable
from instrument.plan import Plan
from instrument.recording import STAGE_COLUMNS, Recording, StageLog, TimingReport
from instrument.storage import layout
from instrument.storage.checksum import FRAMES_A_BLOCK, changed_frames
from instrument.storage.hdf5 import Group
from instrument.storage.hdf5_file import InUse, is_hdf5, open_to_read
from instrument.storage.in_use import has_ended, in_use
from instrument.storage.layout import unusable
from instrument.storage.part import is_locked
from instrument.storage.soundness import HDF5_ERRORS
from instrument.storage.spill import run_of, spills_of
from protocols import Floats, InputError, Mask, Truth
from protocols.plain_file import path_of


def open_recording(path: str | Path, frames: tuple[int, int] | None = None) -> Recording:
    """Read a recording, or some of its frames. A run that broke, or whose program was killed, is a shorter one with a mask.

    A file from anywhere can be given: whatever is in it, the answer is a recording or an ``InputError``. Links out of the file
    are never followed, and no more memory is taken than the file really fills.

    Args:
        path: of the file.
        frames: first frame, and the one after the last, that are read and given, as ``Recording.part`` gives them; None for all.
            Of a file that was closed no others are read. Checksums are of a hundred frames: those that lie inside are looked at.

    Raises:
        InputError: no such file, no HDF5, no recording, of a later layout, truncated, damaged, changed after the run, or open
            for writing in another program: says which, and the path inside the file; or it has no such frames.
    """
    path = path_of(path)
    with opened_recording(path) as entry:
        if frames is not None and has_ended(entry):
            return _recording(path, entry, _some(path, entry, *frames))
        recording = _recording(path, entry)
    return recording if frames is None else recording.part(*frames)


@dataclass(frozen=True)
class _Some:
    """Some frames of a recording."""

    first: int
    """First frame."""

    end: int
    """Frame after the last one."""

    every: int
    """Number of all frames."""


def _some(path: Path, entry: Group, first: int, end: int) -> _Some:
    every = entry.shape(layout.VALUES)[0]
    if not 0 <= first < end <= every:
        raise InputError(
            saw=f"frames {first} to {end} of {path}",
            expected=f"frames from 0 on, before {every}",
            remedy="ask for frames that the recording has",
        )
    return _Some(first, end, every)


@dataclass(frozen=True, eq=False)
class RawCounts:
    """What the counter gave, in the order of arrival, to hold the values against."""

    counts: Floats
    """``(n,)``: counts of each bin."""

    edge_time_s: Floats
    """``(n,)``: opening edge of each bin, s; NaN without edge times."""

    checksums: int
    """How many checksums the recording has; 0 where it was not closed."""


def raw_counts(path: str | Path) -> RawCounts:
    """Read the raw counts of a recording. Of a run that was killed, those without an edge time are left out.

    Raises:
        InputError: as ``open_recording``.
    """
    path = Path(path)
    with opened_recording(path) as entry:
        counts, edges = _floats(entry, layout.RAW_COUNTS), _floats(entry, layout.RAW_EDGE_TIME_S)
        names = [name for name in (layout.CHECKSUM_VALUES, layout.CHECKSUM_EDGES) if name in entry]
        bins = min(len(counts), len(edges))
        return RawCounts(counts[:bins], edges[:bins], sum(entry.array(name).size for name in names))


@contextmanager
def opened_recording(path: Path) -> Generator[Group]:
    """Open a recording and give its entry; what goes wrong while it is open is told as a file that cannot be read.

    Raises:
        InputError: as ``open_recording``.
    """
    if not path.is_file():
        what = "a folder" if path.is_dir() else "no ordinary file" if path.exists() else "no such file"
        raise unusable(path, what, "give the path of a recording (.h5)")
    if path.stat().st_size == 0:
        raise unusable(path, "an empty file", _remedy(path, "give the path of a recording (.h5)"))
    try:
        if not is_hdf5(path):
            raise unusable(
                path, "something else than an HDF5 file", _remedy(path, "give the path of a recording (.h5)")
            )
        with open_to_read(path) as file:
            yield _entry(path, file)
    except InputError:
        raise
    except InUse as error:
        raise in_use(path) from error
    except HDF5_ERRORS as error:
        what = "a truncated file" if "truncated" in str(error) else "a damaged file"
        raise unusable(
            path, f"{what} ({error})", _remedy(path, "take the file from a backup or copy it again, or repeat the run")
        ) from error


def _remedy(path: Path, otherwise: str) -> str:
    """What to do with a file that cannot be read: there may be a journal of it."""
    recover = f"`kinopix recover {path}` makes it anew from the journal beside it"
    return recover if any(spill.empty_recording for spill in spills_of(path.resolve(), None)) else otherwise


def _entry(path: Path, file: Group) -> Group:
    """The entry of a file that is a recording, of a layout that is known, and whole."""
    if "entry/definition" not in file or file.text("entry/definition") != layout.DEFINITION:
        raise unusable(path, "an HDF5 file by another program", "give the path of a recording (.h5)")
    entry = file.at("entry")
    version = str(entry.attribute_of("definition", "version"))
    if version.split(".", maxsplit=1)[0] != layout.VERSION.split(".", maxsplit=1)[0]:
        raise unusable(
            path,
            f"a recording of layout {version}, while this program reads {layout.VERSION}",
            "install a newer Kinopix",
        )
    _refuse_cut_off(path, entry)
    return entry


def _recording(path: Path, entry: Group, some: _Some | None = None) -> Recording:
    plan = plan_of(path, entry)
    values = _floats(entry, layout.VALUES, some)
    refuse_narrow_values(path, values.shape, plan)
    edge_time_s = _edge_time_s(path, entry, values, some)
    _refuse_changed(path, entry, values, edge_time_s, some)
    if some is None:
        _refuse_torn(path, entry, values, edge_time_s)
    timing = timing_of(entry)
    return Recording(
        plan=plan,
        values=values,
        frame_valid=_frame_valid(path, entry, values, some),
        picture_time_s=_at_least(path, entry, layout.PICTURE_TIME_S, "more than 0 s", np.nextafter(0.0, 1.0)),
        edge_time_s=edge_time_s if np.isfinite(edge_time_s).any() else None,
        photon_counts=bool(_at_least(path, entry, layout.PHOTON_COUNTS, "0 or 1")),
        dead_time_s=_at_least(path, entry, layout.DEAD_TIME_S, "0 s or more"),
        dark_rate_hz=_at_least(path, entry, layout.DARK_RATE_HZ, "0 Hz or more"),
        light=_light(entry),
        calibration=_calibration(entry),
        stage=_stage(entry) if some is None or some.first == 0 else None,
        truth=_truth(path, entry, plan, len(values), some),
        timing=timing if timing is None or some is None else timing.part(some.first, some.end),
        path=path,
    )


def _light(entry: Group) -> LightTable:
    """What the bench said of its light; nothing where an older program wrote the recording, or the text is of no use."""
    try:
        bench: dict[str, Any] = json.loads(entry.text(layout.BENCH)) if layout.BENCH in entry else {}
        return LightTable.model_validate(bench.get("light") or {})
    except (ValueError, AttributeError):
        return NOTHING_KNOWN


def _calibration(entry: Group) -> Calibration | None:
    """The calibration of the bench; None where it had none, or where another program wrote one that this does not know."""
    try:
        bench: dict[str, Any] = json.loads(entry.text(layout.BENCH)) if layout.BENCH in entry else {}
        stored = bench.get("calibration")
        return None if stored is None else Calibration.model_validate_json(json.dumps(stored))
    except (ValueError, AttributeError):
        return None


def _stage(entry: Group) -> StageLog | None:
    """Where the stage was; None in older files, and where nothing of the kind is stored."""
    rows = _floats(entry, layout.STAGE_POSITIONS) if layout.STAGE_POSITIONS in entry else np.zeros((0, 0))
    if rows.ndim != 2 or rows.shape[1] != STAGE_COLUMNS or not len(rows) or not np.isfinite(rows).all():
        return None
    return StageLog.of_rows(rows)


def _refuse_cut_off(path: Path, entry: Group) -> None:
    """Refuse what has lost its end since its writer died, before HDF5 looks for it, at length and in vain."""
    written = int(entry.number(layout.FILE_BYTES)) if layout.FILE_BYTES in entry else 0
    size = path.stat().st_size
    if size < written:
        raise OSError(f"truncated: the recording goes on to byte {written}, the file ends at {size}")


def plan_of(path: Path, entry: Group) -> Plan:
    """The plan of an open recording.

    Raises:
        InputError: this program does not know it.
    """
    try:
        return Plan.from_json(entry.text(layout.PLAN))
    except (ValueError, TypeError, AttributeError, RecursionError, ArithmeticError) as error:
        why = " ".join(str(error).split())  # on one line
        saw = f"a plan that this program does not know ({why}) at /entry/{layout.PLAN}"
        raise unusable(path, saw, "install a newer Kinopix") from error
    except InputError as error:
        saw = f"a plan that this program does not know: {error.saw}"
        raise unusable(path, saw, "install the distribution that offers its scheme") from error


def refuse_narrow_values(path: Path, shape: tuple[int, ...], plan: Plan) -> None:
    """Refuse values that are not a row of patterns for each frame.

    Raises:
        InputError: names both shapes.
    """
    patterns = plan.patterns_per_frame
    if len(shape) != 2 or shape[1] != patterns:
        raise unusable(path, f"values of shape {shape}, not (frames, {patterns})", "repeat the run")


def refuse_other_mask(path: Path, shape: tuple[int, ...], frames: int) -> None:
    """Refuse a mask that is not one flag a frame.

    Raises:
        InputError: names both.
    """
    if shape != (frames,):
        flags = shape[0] if len(shape) == 1 else shape
        saw = f"a mask of {flags} frames for {frames} frames of values at /entry/{layout.FRAME_VALID}"
        raise unusable(path, saw, "repeat the run")


def _frame_valid(path: Path, entry: Group, values: Floats, some: _Some | None) -> Mask:
    """The mask of the audit; where there was none, the frames in which every pattern has a value."""
    measured = layout.measured_frames(values)
    if layout.FRAME_VALID not in entry:  # layout 1.0
        return measured
    valid = entry.array(layout.FRAME_VALID).astype(bool)
    if not valid.size:  # not finished yet, or never
        return measured
    refuse_other_mask(path, valid.shape, len(measured) if some is None else some.every)
    return valid if some is None else valid[some.first : some.end]


def _edge_time_s(path: Path, entry: Group, values: Floats, some: _Some | None) -> Floats:
    """As ``values``; a run that was killed has edges of more frames, as they are written first."""
    edges = _floats(entry, layout.EDGE_TIME_S, some)
    if edges.ndim != 2 or edges.shape[1] != values.shape[1] or len(edges) < len(values):
        saw = f"edge times of shape {edges.shape} for values of shape {values.shape} at /entry/{layout.EDGE_TIME_S}"
        raise unusable(path, saw, "repeat the run")
    return edges[: len(values)]


def _refuse_changed(path: Path, entry: Group, values: Floats, edge_time_s: Floats, some: _Some | None) -> None:
    """Hold the numbers against their checksums, which the writer made of what the counter gave it."""
    first, whole = (0, slice(None)) if some is None else _whole_blocks(some)
    for name, what, rows in (
        (layout.CHECKSUM_VALUES, "values", values),
        (layout.CHECKSUM_EDGES, "edge times", edge_time_s),
    ):
        if name not in entry:  # layout 1.1
            continue
        checksums = entry.array(name)
        if not checksums.size:  # not finished yet, or never
            continue
        if some is not None:
            checksums = checksums[first // FRAMES_A_BLOCK :][: -(-len(rows[whole]) // FRAMES_A_BLOCK)]
        changed = changed_frames(rows[whole], checksums, first)
        if changed:
            raise unusable(
                path,
                f"{what} of {changed} that were changed after the run",
                "take the file from a backup; to use the numbers as they are, remove /entry/checksum from the file",
            )


def _whole_blocks(some: _Some) -> tuple[int, slice]:
    """Give the first frame of the first block of frames with a checksum that lies inside, and which rows have one."""
    first = -(-some.first // FRAMES_A_BLOCK) * FRAMES_A_BLOCK
    end = some.end if some.end == some.every else some.end // FRAMES_A_BLOCK * FRAMES_A_BLOCK
    return first, slice(first - some.first, max(first, end) - some.first)


def _refuse_torn(path: Path, entry: Group, values: Floats, edge_time_s: Floats) -> None:
    """Hold a recording that was left open against its journal: after a power cut, zeros may stand for what was not synced.

    Raises:
        InputError: it does not agree, or holds more than its journal, which is written first.
    """
    if has_ended(entry) or is_locked(path) is not False:
        return
    run = run_of(entry.text(layout.START_TIME), entry.attribute_of(layout.PROGRAM_NAME, "process_id"))
    numbers = {layout.VALUES: values.ravel(), layout.EDGE_TIME_S: edge_time_s.ravel()}
    written = np.isfinite(values.ravel())  # a program may be killed in the middle of writing what its journal has
    for journal in (spill for spill in spills_of(path.resolve(), run) if spill.empty_recording):
        end = 0
        for record in journal.records:
            if record.what in numbers:
                there = numbers[record.what][record.first : record.first + len(record.numbers)]
                which = written[record.first : record.first + len(there)]
                if not np.array_equal(there[which], record.numbers[: len(there)][which], equal_nan=True):
                    raise _torn(path)
            if record.what == layout.VALUES:
                end = record.first + len(record.numbers)
        if np.isfinite(values.ravel()[end:]).any():
            raise _torn(path)


def _torn(path: Path) -> InputError:
    """Make the error for a recording that only its journal can tell."""
    return unusable(
        path, "a recording that a power cut has left half written", f"`kinopix recover {path}` makes it anew"
    )


def _at_least(path: Path, entry: Group, name: str, expected: str, least: float = 0.0) -> float:
    value = entry.number(name)
    if not least <= value < np.inf:
        raise unusable(
            path, f"{value:g} at /entry/{name}, not {expected}", "take the file from a backup, or repeat the run"
        )
    return value


def _floats(entry: Group, name: str, some: _Some | None = None) -> Floats:
    numbers = entry.array(name) if some is None else entry.part(name, some.first, some.end)
    return numbers.astype(np.float64, copy=False)


def timing_of(entry: Group) -> TimingReport | None:
    """The audit; None where the run was cut off before it, or where another program left it out."""
    if layout.TIMING_REPORT not in entry:
        return None
    try:
        return TimingReport.model_validate_json(entry.text(layout.TIMING_REPORT))
    except (ValidationError, RecursionError):
        return None


def _truth(path: Path, entry: Group, plan: Plan, frames: int, some: _Some | None) -> Truth | None:
    if layout.TRUTH_IMAGE not in entry:
        return None
    displacement_px = _floats(entry, layout.TRUTH_DISPLACEMENT_PX, some)
    if not displacement_px.size:  # not finished yet, or never
        return None
    image = _floats(entry, layout.TRUTH_IMAGE)
    # Files of before have no such dataset, and a run without a background has no rows in it.
    background = _floats(entry, layout.TRUTH_BACKGROUND) if layout.TRUTH_BACKGROUND in entry else np.empty(0)
    size = plan.image_size
    images = (image, background) if background.size else (image,)
    if displacement_px.shape != (frames, 2) or any(one.shape != (size, size) for one in images):
        found = ", ".join(str(one.shape) for one in (displacement_px, *images))
        raise unusable(
            path, f"a truth of shapes {found} at /entry/truth, not ({frames}, 2), ({size}, {size})", "repeat the run"
        )
    if not (np.isfinite(displacement_px).all() and all(np.isfinite(one).all() for one in images)):
        raise unusable(
            path, "a truth that is not finite at /entry/truth", "take the file from a backup, or repeat the run"
        )
    return Truth(displacement_px=displacement_px, image=image, background=background if background.size else None)
