"""A recording whose run did not close it, made whole: what it holds, and what was spilled beside it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from instrument.storage import layout
from instrument.storage.checksum import Checksums
from instrument.storage.edit import refuse_unchangeable, rewritten
from instrument.storage.hdf5 import Group
from instrument.storage.in_use import has_ended, refuse_while_written
from instrument.storage.provenance import now
from instrument.storage.reader import opened_recording, plan_of
from instrument.storage.spill import EMPTY_RECORDING, Record, Spill, read_spill, run_of, spills_of
from protocols import Floats, InputError

_RAW = (layout.RAW_EDGE_TIME_S, layout.RAW_COUNTS)
_PLACED = (layout.EDGE_TIME_S, layout.VALUES)
_CUT_OFF = "cut off: its program ended without closing the file"


@dataclass(frozen=True)
class Recovered:
    """What a recovery gave."""

    path: Path
    """The recording that is whole now."""

    patterns: int
    """Patterns it has."""

    joined: int
    """Patterns of those that came from spill files alone."""

    spills: tuple[Path, ...]
    """Spill files that are in it now, and were removed."""

    lost_bytes: int
    """Bytes of spill files that were cut off, and are not in it."""


def recover(path: str | Path, *, spill: str | Path | None = None, into: str | Path | None = None) -> Recovered | None:
    """Make an ordinary recording of one whose program ended without closing it, with every count that was spilled.

    A copy is made, handed to the disk, and then takes the place of the recording by one rename: until then the recording and
    its spill files stay as they are. Spill files are looked for beside the recording and in the temporary folder.

    Args:
        path: the recording.
        spill: a spill file that is somewhere else.
        into: a new file for the result, where the disk of the recording is full; the recording stays then, and so do its
            spill files.

    Returns:
        None where there is nothing to do: the recording was closed, and nothing is spilled.

    Raises:
        InputError: the recording cannot be read, is being written, or may not be replaced; the spill file belongs to another
            run, or counts between both are missing; or there is no room for the copy.
    """
    path, into = Path(path), None if into is None else Path(into)
    refuse_while_written(path)
    state, spills = _found(path, None if spill is None else Path(spill))
    journals = [each for each in spills if each.empty_recording]
    if state.closed and len(spills) == len(journals):
        for each in journals:  # the program was killed before it could
            each.path.unlink(missing_ok=True)
        return None
    empty = journals[0].empty_recording if journals else b""
    refuse_unchangeable(path, into, content=not empty)
    records = [record for each in spills for record in each.records if record.what != EMPTY_RECORDING]
    more_bytes = len(empty) + sum(record.numbers.nbytes + len(record.text) for record in records)
    with rewritten(path, into, more_bytes=more_bytes, instead=empty) as entry:
        before = state.patterns
        planned, complete = plan_of(path, entry).patterns, bool(int(entry.attribute("complete")))
        for names in (_RAW, _PLACED):
            _join(path, entry, names, records)
        values = entry.rows(layout.VALUES).read()
        after = _measured(values)
        texts = {record.what: record.text for record in records if record.text}
        if not state.closed or texts:
            _close(entry, records, values, texts, whole=complete or after >= planned)
    if into is None:
        for each in spills:
            each.path.unlink(missing_ok=True)
    return Recovered(
        path=path if into is None else into,
        patterns=after,
        joined=max(0, after - before),
        spills=tuple(each.path for each in spills),
        lost_bytes=sum(each.lost_bytes for each in spills),
    )


@dataclass(frozen=True)
class _State:
    """What a recording is before it is recovered."""

    closed: bool
    patterns: int


def _found(path: Path, spill: Path | None) -> tuple[_State, list[Spill]]:
    """What the recording is, and its spill files. One that cannot be read needs a journal.

    Raises:
        InputError: it cannot be read, and there is none.
    """
    try:
        with opened_recording(path) as entry:
            run = run_of(entry.text(layout.START_TIME), entry.attribute_of(layout.PROGRAM_NAME, "process_id"))
            state = _State(has_ended(entry), _measured(entry.array(layout.VALUES)))
            plan_of(path, entry)
    except InputError:
        spills = spills_of(path.resolve(), None) if spill is None else [read_spill(spill)]
        if path.is_file() and any(each.empty_recording for each in spills):
            return _State(closed=False, patterns=0), spills
        raise
    return state, spills_of(path.resolve(), run) if spill is None else [_of_run(spill, run, path)]


def _of_run(path: Path, run: str, recording: Path) -> Spill:
    spill = read_spill(path)
    if spill.run != run:
        raise InputError(
            saw=f"{path}, which belongs to the run {spill.run}",
            expected=f"counts of the run {run}, which {recording} is of",
            remedy="name the recording that it was spilled from",
        )
    return spill


def _measured(values: Floats) -> int:
    """Patterns up to the last one that has a value; those after it are the rest of an open frame."""
    found = np.flatnonzero(np.isfinite(values.ravel()))
    return int(found[-1]) + 1 if len(found) else 0


def _join(path: Path, entry: Group, names: Sequence[str], records: Sequence[Record]) -> None:
    """Write the spilled numbers of two datasets that go together into their places; both end where the shorter one ends."""
    joined = [_with(path, name, entry.rows(name).read().ravel(), records) for name in names]
    for name, numbers in zip(names, joined, strict=True):
        width = entry.rows(name).width
        length = min(len(each) for each in joined)
        padded = np.full(-(-length // width) * width, np.nan)
        padded[:length] = numbers[:length]
        shape = (-1,) if len(entry.shape_of(name)) == 1 else (-1, width)
        entry.rows(name).replace(padded.reshape(shape))


def _with(path: Path, name: str, numbers: Floats, records: Sequence[Record]) -> Floats:
    """The numbers of a dataset, with those of the records over and behind them."""
    mine = sorted((record for record in records if record.what == name), key=lambda record: record.first)
    end = len(numbers)
    for record in mine:
        if record.first > end:
            raise InputError(
                saw=f"{path}, which holds {end} numbers of {name}, and spilled ones from {record.first} on",
                expected="a recording that goes on until its spilled counts begin",
                remedy="take the recording from a backup; another program has cut it, or it is of another run",
            )
        end = max(end, record.first + len(record.numbers))
    longer = np.full(end, np.nan)
    longer[: len(numbers)] = numbers
    for record in mine:
        longer[record.first : record.first + len(record.numbers)] = record.numbers
    return longer


def _close(entry: Group, records: Sequence[Record], values: Floats, texts: dict[str, str], *, whole: bool) -> None:
    """Fill in what a run fills in at its end, from the spill file as far as it has it."""
    numbers = {record.what: record.numbers for record in records if not record.text}
    frames = len(values)
    valid = numbers.get(layout.FRAME_VALID)
    measured = layout.measured_frames(values)
    entry.rows(layout.FRAME_VALID).replace((measured if valid is None else valid[:frames] != 0).astype(np.uint8))
    if layout.PHOTON_COUNTS in numbers:
        entry.set_value(layout.PHOTON_COUNTS, bool(numbers[layout.PHOTON_COUNTS][0]))
    truth, image = numbers.get(layout.TRUTH_DISPLACEMENT_PX), numbers.get(layout.TRUTH_IMAGE)
    if truth is not None and image is not None and layout.TRUTH_IMAGE in entry:
        side = entry.shape_of(layout.TRUTH_IMAGE)
        entry.set_value(layout.TRUTH_IMAGE, image.reshape(side))
        entry.rows(layout.TRUTH_DISPLACEMENT_PX).replace(truth.reshape(-1, 2))
    for name in (layout.TIMING_REPORT, layout.INTERRUPTED):
        if texts.get(name):
            entry.set_value(name, texts[name])
    edges = entry.rows(layout.EDGE_TIME_S).read()
    for name, rows in ((layout.CHECKSUM_VALUES, values), (layout.CHECKSUM_EDGES, edges)):
        sums = Checksums(values.shape[1])
        sums.add(rows.ravel())
        entry.rows(name).replace(sums.finished())
    if not entry.text(layout.END_TIME):
        entry.set_value(layout.END_TIME, now())
    ended_well = whole and layout.TIMING_REPORT in texts and layout.INTERRUPTED not in texts
    if not ended_well and not entry.text(layout.INTERRUPTED):
        entry.set_value(layout.INTERRUPTED, _CUT_OFF)
    entry.set_attribute("complete", value=ended_well)
