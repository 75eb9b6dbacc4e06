"""``recover``: what a run left behind becomes a whole recording, and nothing is lost on the way."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.storage import RecordingWriter, layout, open_recording, recording_info, recover
from instrument.storage.spill import Record, write_spill
from protocols import CountBlock, Floats, InputError
from tests.support import plain_hdf5 as plain

VALUES = np.arange(600, dtype=np.float64) + 0.5
EDGES: Floats = np.arange(600, dtype=np.float64) * 50e-6
NONE = np.empty(0)


def left_behind(folder: Path, patterns: int = 300) -> tuple[Path, str]:
    """A recording whose program did not close it, and the name of its run."""
    made = RecordingWriter(folder / "made.h5", Plan(frames=100, image_size=8), picture_time_s=50e-6)
    if patterns:
        made.append_raw(CountBlock(0, VALUES[:patterns], EDGES[:patterns], patterns * 50e-6))
        made.append(VALUES[:patterns], EDGES[:patterns])
    made.sync()
    run = made.run
    shutil.copy(folder / "made.h5", folder / "run.h5")
    made.close()
    (folder / "made.h5").unlink()
    return folder / "run.h5", run


def spilled(first: int, end: int) -> list[Record]:
    return [
        Record(layout.RAW_EDGE_TIME_S, first, EDGES[first:end]),
        Record(layout.RAW_COUNTS, first, VALUES[first:end]),
        Record(layout.EDGE_TIME_S, first, EDGES[first:end]),
        Record(layout.VALUES, first, VALUES[first:end]),
    ]


def test_a_recording_that_was_cut_off_is_closed(tmp_path: Path) -> None:
    path, _ = left_behind(tmp_path, 297)
    assert recording_info(path).state == "cut off"
    done = recover(path)
    assert done is not None
    assert (done.patterns, done.joined, done.spills) == (297, 0, ())
    info = recording_info(path)
    assert info.state == "interrupted"
    assert info.interrupted == "cut off: its program ended without closing the file"
    assert info.frames_masked == 1  # 297 = 49 x 6 + 3
    assert len(plain.array(path, "entry/checksum/values")) == 1
    np.testing.assert_array_equal(open_recording(path).values.ravel()[:297], VALUES[:297])
    assert recover(path) is None


def test_a_recording_without_one_value_is_closed_as_empty_and_takes_all_from_its_spill_file(tmp_path: Path) -> None:
    made = RecordingWriter(tmp_path / "run.h5", Plan(frames=100, image_size=8), picture_time_s=50e-6)
    made.abandon()
    shutil.copy(tmp_path / "run.h5", tmp_path / "empty.h5")
    done = recover(tmp_path / "empty.h5")
    assert done is not None
    assert (done.patterns, done.joined) == (0, 0)
    write_spill(tmp_path / "run.h5.1.spill", made.run, spilled(0, 600))
    done = recover(tmp_path / "run.h5")
    assert done is not None
    assert (done.patterns, done.joined) == (600, 600)


@pytest.mark.parametrize("first", [0, 100, 299, 300])
def test_spilled_counts_are_joined_wherever_they_begin(tmp_path: Path, first: int) -> None:
    path, run = left_behind(tmp_path)
    write_spill(tmp_path / "run.h5.1.spill", run, [*spilled(first, 450), *spilled(450, 600)])
    done = recover(path)
    assert done is not None
    assert (done.patterns, done.joined) == (600, 300)
    recording = open_recording(path)
    np.testing.assert_array_equal(recording.values.ravel(), VALUES)
    assert recording.edge_time_s is not None
    np.testing.assert_array_equal(recording.edge_time_s.ravel(), EDGES)
    np.testing.assert_array_equal(plain.array(path, "entry/instrument/counter/raw_counts"), VALUES)
    assert list(tmp_path.iterdir()) == [path]


def test_a_run_that_only_its_disk_ended_is_whole_again(tmp_path: Path) -> None:
    path, run = left_behind(tmp_path)
    ending = [
        Record(layout.FRAME_VALID, 0, np.arange(100) != 3.0),
        Record(layout.TIMING_REPORT, 0, NONE, '{"gaps": []}'),
        Record(layout.PHOTON_COUNTS, 0, np.ones(1)),
    ]
    write_spill(tmp_path / "run.h5.1.spill", run, [*spilled(300, 600), *ending])
    recover(path)
    assert recording_info(path).state == "complete"
    recording = open_recording(path)
    assert np.flatnonzero(~recording.frame_valid).tolist() == [3]
    assert recording.photon_counts
    assert plain.text(path, "entry/timing/report") == '{"gaps": []}'


def test_the_truth_of_a_simulated_run_is_taken_from_the_spill_file(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    made = RecordingWriter(path, Plan(frames=100, image_size=8), picture_time_s=50e-6, with_truth=True)
    made.abandon()
    moved_px, image = np.arange(200.0).reshape(100, 2), np.arange(64.0).reshape(8, 8)
    truth = [
        Record(layout.TRUTH_DISPLACEMENT_PX, 0, moved_px.ravel()),
        Record(layout.TRUTH_IMAGE, 0, image.ravel()),
    ]
    write_spill(tmp_path / "run.h5.1.spill", made.run, [*spilled(0, 600), *truth])
    recover(path)
    found = open_recording(path).truth
    assert found is not None
    np.testing.assert_array_equal(found.displacement_px, moved_px)
    np.testing.assert_array_equal(found.image, image)


def test_counts_between_recording_and_spill_file_that_are_missing_change_nothing(tmp_path: Path) -> None:
    path, run = left_behind(tmp_path)
    spill, before = tmp_path / "run.h5.1.spill", path.read_bytes()
    write_spill(spill, run, spilled(301, 600))
    with pytest.raises(InputError, match=r"which holds 300 numbers of .*, and spilled ones from 301 on"):
        recover(path)
    assert path.read_bytes() == before
    assert sorted(tmp_path.iterdir()) == [path, spill]


def test_a_copy_elsewhere_leaves_everything_where_it_is(tmp_path: Path) -> None:
    path, run = left_behind(tmp_path)
    spill, before = tmp_path / "run.h5.1.spill", path.read_bytes()
    write_spill(spill, run, spilled(300, 600))
    done = recover(path, into=tmp_path / "whole.h5")
    assert done is not None
    assert done.path == tmp_path / "whole.h5"
    assert len(open_recording(done.path)) == 100
    assert path.read_bytes() == before
    assert spill.exists()


def test_the_spill_file_of_another_run_is_neither_found_nor_taken(tmp_path: Path) -> None:
    path, _ = left_behind(tmp_path)
    other = tmp_path / "run.h5.1.spill"
    write_spill(other, "another run", spilled(300, 600))
    with pytest.raises(InputError, match="which belongs to the run another run"):
        recover(path, spill=other)
    done = recover(path)
    assert done is not None
    assert done.patterns == 300
    assert other.exists()


def test_what_is_no_spill_file_is_refused(tmp_path: Path) -> None:
    path, _ = left_behind(tmp_path)
    for content in (b"", b"\x00" * 100, b'{"format": "kinopix-spill", "version": 2}\n', b"[" * 100_000 + b"\n"):
        (tmp_path / "x").write_bytes(content)
        with pytest.raises(InputError, match="no spill file"):
            recover(path, spill=tmp_path / "x")
    with pytest.raises(InputError, match="cannot be read"):
        recover(path, spill=tmp_path / "missing")
