"""A run and a disk that is slow, refuses, or does not answer: nothing waits for it, and every count is kept."""

import errno
import os
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from threading import Event

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.storage import (
    Keeper,
    RecordingWriter,
    Rescue,
    StorageFailed,
    made_in_time,
    open_recording,
    recover,
)
from instrument.storage.spill import Record, read_spill, write_spill
from protocols import CountBlock, Floats, InputError
from tests.support import plain_hdf5 as plain

PLAN = Plan(frames=100, image_size=8)
VALUES = np.arange(600, dtype=np.float64) + 0.25
EDGES: Floats = np.arange(600, dtype=np.float64) * 50e-6


def keeper(
    path: Path, sync: Callable[[int], object] = os.fsync, patience_s: float = 30.0, most_bytes: int = 1 << 20
) -> Keeper:
    writer = RecordingWriter(path, PLAN, picture_time_s=50e-6, sync=sync)
    return Keeper(writer, patience_s=patience_s, most_bytes=most_bytes)


def feed(kept: Keeper, first: int, end: int) -> None:
    kept.raw(CountBlock(first, VALUES[first:end], EDGES[first:end], float(end * 50e-6)))
    kept.placed(VALUES[first:end], EDGES[first:end])


def finish(kept: Keeper, frames: int = 100) -> Rescue | None:
    return kept.finish(frame_valid=np.arange(frames) != 7, report='{"a": 1}')


def wait_for_failure(kept: Keeper) -> StorageFailed:
    with pytest.raises(StorageFailed) as caught:  # noqa: PT012
        while True:
            kept.check()
            Event().wait(0.01)
    return caught.value


def test_a_disk_that_works_gives_the_same_recording_as_the_writer_alone(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    kept = keeper(path)
    for first in range(0, 600, 100):
        feed(kept, first, first + 100)
    assert finish(kept) is None
    recording = open_recording(path)
    np.testing.assert_array_equal(recording.values.ravel(), VALUES)
    assert np.flatnonzero(~recording.frame_valid).tolist() == [7]
    assert plain.attribute(path, "entry", "complete") == 1
    assert list(tmp_path.iterdir()) == [path]


def test_blocks_are_copied_when_they_are_handed_over(tmp_path: Path) -> None:
    """A driver may use its buffer again at once."""
    path, buffer = tmp_path / "run.h5", VALUES.copy()
    kept = keeper(path)
    kept.raw(CountBlock(0, buffer))
    kept.placed(buffer, None)
    buffer[:] = -1
    assert finish(kept) is None
    np.testing.assert_array_equal(open_recording(path).values.ravel(), VALUES)
    np.testing.assert_array_equal(plain.array(path, "entry/instrument/counter/raw_counts"), VALUES)


def test_counts_are_synced_while_the_run_goes_on(tmp_path: Path) -> None:
    synced = Event()

    def sync(file: int) -> None:
        os.fsync(file)
        synced.set()

    kept = keeper(tmp_path / "run.h5", sync)
    feed(kept, 0, 100)
    assert synced.wait(20)
    assert finish(kept, 17) is None


def test_a_slow_sync_delays_nobody(tmp_path: Path) -> None:
    """It hangs until all blocks are handed over, which they can only be if nobody waits for it."""
    began, go_on = Event(), Event()

    def sync(file: int) -> None:
        began.set()
        assert go_on.wait(20)

    kept = keeper(tmp_path / "run.h5", sync)
    feed(kept, 0, 100)
    assert began.wait(20)
    for first in range(100, 600, 100):
        feed(kept, first, first + 100)
    go_on.set()
    assert finish(kept) is None
    assert len(open_recording(tmp_path / "run.h5")) == 100


def test_a_sync_that_fails_ends_the_run_and_spills_what_it_did_not_cover(tmp_path: Path) -> None:
    path, calls = tmp_path / "run.h5", list[int]()

    def sync(file: int) -> None:
        calls.append(file)
        if len(calls) == 1:
            raise OSError(errno.EIO, os.strerror(errno.EIO))

    kept = keeper(path, sync)
    feed(kept, 0, 600)
    failure = wait_for_failure(kept)
    assert "run.h5, which could not be written: [Errno 5]" in str(failure)
    assert failure.exit_code == 3
    assert not failure.hangs
    rescue = finish(kept)
    assert rescue is not None
    assert rescue.kept_until == 0
    assert rescue.spill is not None
    assert rescue.spill.parent == tmp_path
    assert (rescue.lost, rescue.doubt) == ("", "")
    before = path.read_bytes()
    recovered = recover(path)
    assert recovered is not None
    assert recovered.patterns == 600
    assert path.read_bytes() != before
    recording = open_recording(path)
    np.testing.assert_array_equal(recording.values.ravel(), VALUES)
    assert np.flatnonzero(~recording.frame_valid).tolist() == [7]
    assert plain.text(path, "entry/timing/report") == '{"a": 1}'
    assert list(tmp_path.iterdir()) == [path]


def test_a_disk_that_does_not_answer_ends_the_run_in_time(tmp_path: Path) -> None:
    let_go, begun_s = Event(), time.monotonic()
    kept = keeper(tmp_path / "run.h5", lambda _file: let_go.wait(20), patience_s=0.2)
    feed(kept, 0, 300)
    failure = wait_for_failure(kept)
    assert "whose disk has not answered for 0." in str(failure)
    assert failure.hangs
    rescue = finish(kept, 50)
    assert time.monotonic() - begun_s < 10
    let_go.set()
    assert rescue is not None
    assert rescue.spill is not None
    assert "no answer" in rescue.doubt
    recovered = recover(tmp_path / "run.h5", spill=rescue.spill)
    assert recovered is not None
    np.testing.assert_array_equal(open_recording(tmp_path / "run.h5").values.ravel(), VALUES[:300])


def test_memory_is_bounded_while_the_disk_is_slow(tmp_path: Path) -> None:
    """Room for one and a half pieces: the second one waits until the first one is on the disk."""
    go_on = Event()
    most = 8 * 200  # a piece of 100 values and 100 edges
    kept = keeper(tmp_path / "run.h5", lambda _file: go_on.wait(20), patience_s=0.3, most_bytes=most)
    kept.placed(VALUES[:100], EDGES[:100])
    with pytest.raises(StorageFailed, match="has not answered"):
        kept.placed(VALUES[100:200], EDGES[100:200])
    go_on.set()
    assert finish(kept, 34) is not None


def test_a_file_that_another_program_cuts_is_noticed_before_hdf5_meets_it(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    kept = written(path)
    os.truncate(path, 1000)
    feed_until_it_fails(kept)
    rescue = finish(kept)
    assert rescue is not None
    assert rescue.error.cut
    assert "another program has cut while it was recorded: it has 1000 bytes now" in str(rescue.error)
    assert path.stat().st_size == 1000  # HDF5 did not touch it again
    assert rescue.spill is not None


@pytest.mark.skipif(sys.platform != "linux", reason="blocks are taken ahead on Linux")
def test_a_file_that_is_cut_and_grows_again_is_noticed_by_its_blocks(tmp_path: Path) -> None:
    """As it is where it is cut in the middle of a write: HDF5 goes on behind the hole."""
    path = tmp_path / "run.h5"
    kept = written(path)
    size = path.stat().st_size
    os.truncate(path, 1000)
    os.truncate(path, size)
    feed_until_it_fails(kept)
    rescue = finish(kept)
    assert rescue is not None
    assert rescue.error.cut


def written(path: Path) -> Keeper:
    """A keeper whose first values are in the file, and nothing is being written."""
    synced = Event()
    kept = keeper(path, lambda _file: synced.set())
    kept.placed(VALUES[:100], EDGES[:100])
    assert synced.wait(20)
    return kept


def feed_until_it_fails(kept: Keeper) -> None:
    for first in range(100, 600, 100):
        try:
            feed(kept, first, first + 100)
        except StorageFailed:
            return


def test_counts_go_to_the_temporary_folder_where_the_folder_takes_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "disk").mkdir()
    (tmp_path / "tmp").mkdir()
    path, elsewhere = tmp_path / "disk" / "run.h5", tmp_path / "tmp"
    monkeypatch.setattr("instrument.storage.spill.tempfile.gettempdir", lambda: str(elsewhere))
    failing = iter([True])

    def sync(_file: int) -> None:
        if next(failing, False):
            raise OSError(errno.EIO, "x")

    def write(place: Path, run: str, records: Iterable[Record]) -> None:
        if place.parent != elsewhere:
            raise OSError(errno.ENOSPC, "full")
        write_spill(place, run, records)

    monkeypatch.setattr("instrument.storage.rescue.write_spill", write)
    kept = keeper(path, sync)
    feed(kept, 0, 600)
    wait_for_failure(kept)
    rescue = finish(kept)
    assert rescue is not None
    assert rescue.spill is not None
    assert rescue.spill.parent == elsewhere
    recovered = recover(path)  # it looks there by itself
    assert recovered is not None
    assert rescue.journal is not None
    assert set(recovered.spills) == {rescue.journal, rescue.spill}
    assert not rescue.spill.exists()


def test_counts_that_nothing_takes_are_named_as_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def write(place: Path, run: str, records: object) -> None:
        raise OSError(errno.ENOSPC, "full")

    monkeypatch.setattr("instrument.storage.rescue.write_spill", write)

    def sync(_file: int) -> None:
        raise OSError(errno.EIO, "x")

    kept = keeper(tmp_path / "run.h5", sync)
    feed(kept, 0, 600)
    wait_for_failure(kept)
    rescue = finish(kept)
    assert rescue is not None
    assert rescue.spill is None
    assert f"{tmp_path}: [Errno 28] full" in rescue.lost


def test_nothing_measured_leaves_nothing(tmp_path: Path) -> None:
    keeper(tmp_path / "run.h5").discard()
    assert list(tmp_path.iterdir()) == []


def test_a_spill_file_is_read_until_its_first_byte_that_is_wrong(tmp_path: Path) -> None:
    def sync(_file: int) -> None:
        raise OSError(errno.EIO, "x")

    kept = keeper(tmp_path / "run.h5", sync)
    feed(kept, 0, 300)
    wait_for_failure(kept)
    rescue = finish(kept, 50)
    assert rescue is not None
    spill = rescue.spill
    assert spill is not None
    raw = spill.read_bytes()
    whole = read_spill(spill)
    assert whole.lost_bytes == 0
    assert [record.what for record in whole.records][:2] == [
        "instrument/counter/raw_edge_time_s",
        "instrument/counter/raw_counts",
    ]
    for end in (len(raw) - 1, len(raw) // 2, 200):
        spill.write_bytes(raw[:end])
        cut = read_spill(spill)
        assert len(cut.records) < len(whole.records)
        assert cut.lost_bytes > 0
    place = raw.index(VALUES[:1].tobytes())  # the first raw count: its record and all after it are left out
    spill.write_bytes(raw[:place] + bytes([raw[place] ^ 1]) + raw[place + 1 :])
    assert len(read_spill(spill).records) == 1


def test_a_disk_that_hangs_while_the_file_is_made_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    let_go, noted = Event(), list[object]()
    monkeypatch.setattr("instrument.storage.hdf5_failure._LEFT_OPEN", noted)

    def make() -> RecordingWriter:
        let_go.wait(20)
        raise OSError

    with pytest.raises(StorageFailed, match=r"has not answered for 0\.1 s"):
        made_in_time(tmp_path / "run.h5", make, 0.1)
    let_go.set()
    assert len(noted) == 1


def test_what_forbids_a_file_is_raised_as_it_is(tmp_path: Path) -> None:
    def make() -> RecordingWriter:
        return RecordingWriter(tmp_path / "missing" / "run.h5", PLAN, picture_time_s=50e-6)

    with pytest.raises(InputError, match="no folder"):
        made_in_time(tmp_path / "run.h5", make)
