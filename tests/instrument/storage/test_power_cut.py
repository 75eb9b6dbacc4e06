"""What a power cut leaves: half an index, zeros for counts. The journal beside the recording has every count that was synced."""

import os
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.storage import Keeper, RecordingWriter, open_recording, raw_counts, recover
from instrument.storage.journal import Journal
from instrument.storage.left_open import LeftOpen, lookup3
from instrument.storage.spill import Record, read_spill, write_spill
from protocols import CountBlock, Floats, InputError, Truth
from tests.support import plain_hdf5 as plain

PLAN = Plan(frames=100, image_size=8)
VALUES = np.arange(600, dtype=np.float64) + 0.25
EDGES: Floats = np.arange(600, dtype=np.float64) * 50e-6


def running(path: Path, patterns: int = 300) -> Keeper:
    """A run that has handed over so many patterns, all of which are written."""
    kept = Keeper(RecordingWriter(path, PLAN, picture_time_s=50e-6))
    for first in range(0, patterns, 100):
        end = first + 100
        kept.raw(CountBlock(first, VALUES[first:end], EDGES[first:end], float(end * 50e-6)))
        kept.placed(VALUES[first:end], EDGES[first:end])
    kept.wait_until_written()
    return kept


@pytest.fixture
def cut(tmp_path: Path) -> Path:
    """A copy of the files of a run that goes on, as a disk has them whose power is cut: 300 patterns."""
    (tmp_path / "run").mkdir()
    (tmp_path / "cut").mkdir()
    kept = running(tmp_path / "run" / "run.h5")
    for file in (tmp_path / "run").iterdir():
        (tmp_path / "cut" / file.name).write_bytes(file.read_bytes())
    kept.finish(frame_valid=np.ones(50, bool), report="{}")
    return tmp_path / "cut" / "run.h5"


def journal_of(path: Path) -> Path:
    (journal,) = path.parent.glob("run.h5.*.spill")
    return journal


def test_the_journal_goes_when_the_recording_is_closed(tmp_path: Path) -> None:
    kept = running(tmp_path / "run.h5", 600)
    assert len(list(tmp_path.iterdir())) == 2
    assert kept.finish(frame_valid=np.ones(100, bool), report="{}") is None
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5"]


def test_a_recording_that_is_nothing_but_zeros_is_made_anew_from_its_journal(cut: Path) -> None:
    cut.write_bytes(bytes(5000))
    with pytest.raises(InputError, match=r"`kinopix recover .*run\.h5` makes it anew"):
        open_recording(cut)
    journal = journal_of(cut)
    done = recover(cut)
    assert done is not None
    assert (done.patterns, done.joined, done.spills) == (300, 300, (journal,))
    recording, raw = open_recording(cut), raw_counts(cut)
    np.testing.assert_array_equal(recording.values.ravel(), VALUES[:300])
    np.testing.assert_array_equal(raw.counts, VALUES[:300])
    np.testing.assert_array_equal(raw.edge_time_s, EDGES[:300])
    assert recording.plan == PLAN
    assert plain.attribute(cut, "entry", "complete") == 0
    assert [file.name for file in cut.parent.iterdir()] == ["run.h5"]


@pytest.mark.parametrize("name", ["run.h5.00000000.spill", "run.h5.ffffffff.spill"])
def test_counts_that_were_spilled_are_joined_with_the_journal_whichever_is_found_first(cut: Path, name: str) -> None:
    """Their names are drawn, and files are found by name."""
    spill = cut.with_name(name)
    more = (("raw_edge_time_s", EDGES), ("raw_counts", VALUES))
    records = [Record(f"instrument/counter/{what}", 300, numbers[300:360]) for what, numbers in more]
    more = (("edge_time_s", EDGES), ("values", VALUES))
    records += [Record(f"data/{what}", 300, numbers[300:360]) for what, numbers in more]
    write_spill(spill, read_spill(journal_of(cut)).run, records)
    done = recover(cut)
    assert done is not None
    assert done.patterns == 360
    np.testing.assert_array_equal(open_recording(cut).values.ravel(), VALUES[:360])
    np.testing.assert_array_equal(raw_counts(cut).edge_time_s, EDGES[:360])


def test_zeros_in_the_place_of_counts_are_not_read_as_counts(cut: Path) -> None:
    content = cut.read_bytes()
    first = content.rindex(VALUES[6:12].tobytes())  # the raw counts come first
    cut.write_bytes(content[:first] + bytes(48) + content[first + 48 :])
    with pytest.raises(InputError, match="a power cut has left half written"):
        open_recording(cut)
    assert recover(cut) is not None
    np.testing.assert_array_equal(open_recording(cut).values.ravel(), VALUES[:300])


def test_counts_that_the_journal_does_not_have_are_not_believed(cut: Path) -> None:
    journal = journal_of(cut)
    journal.write_bytes(journal.read_bytes()[:-8])  # its last record is torn: 200 patterns are left
    with pytest.raises(InputError, match="a power cut has left half written"):
        open_recording(cut)
    done = recover(cut)
    assert done is not None
    assert (done.patterns, done.lost_bytes > 0) == (200, True)


def test_a_killed_recording_is_read_as_it_is(cut: Path) -> None:
    np.testing.assert_array_equal(open_recording(cut).values.ravel(), VALUES[:300])


def test_a_journal_of_a_recording_that_was_closed_is_removed(tmp_path: Path) -> None:
    """The program was killed after it had closed the recording, and before it removed the journal."""
    path = tmp_path / "run.h5"
    kept = running(path, 600)
    journal = journal_of(path)
    content = journal.read_bytes()
    kept.finish(frame_valid=np.ones(100, bool), report="{}")
    journal.write_bytes(content)
    before = path.read_bytes()
    assert recover(path) is None
    assert path.read_bytes() == before
    assert not journal.exists()


def test_a_run_that_goes_on_is_not_recovered(tmp_path: Path) -> None:
    kept = running(tmp_path / "run.h5")
    with pytest.raises(InputError, match="being recorded by process"):
        recover(tmp_path / "run.h5")
    assert journal_of(tmp_path / "run.h5").exists()
    kept.finish(frame_valid=np.ones(50, bool), report="{}")


def test_the_journal_of_another_run_is_not_taken(cut: Path, tmp_path: Path) -> None:
    other = journal_of(cut).read_bytes()
    journal_of(cut).unlink()
    head, _, rest = other.partition(b"\n")
    (cut.parent / "run.h5.0000.spill").write_bytes(head.replace(b"20", b"19", 1) + b"\n" + rest)
    done = recover(cut)
    assert done is not None
    assert done.spills == ()


@pytest.mark.skipif(os.name == "nt", reason="no modes there")
def test_a_journal_is_for_its_owner_alone(cut: Path, tmp_path: Path) -> None:
    kept = running(tmp_path / "run.h5")
    assert journal_of(tmp_path / "run.h5").stat().st_mode & 0o777 == 0o600
    kept.finish(frame_valid=np.ones(50, bool), report="{}")
    assert read_spill(journal_of(cut)).empty_recording.startswith(b"\x89HDF")


@pytest.mark.parametrize(("text", "checksum"), [(b"", 0xDEADBEEF), (b"Four score and seven years ago", 0x17770551)])
def test_checksums_are_those_of_lookup3(text: bytes, checksum: int) -> None:
    """Both are stated in Bob Jenkins' lookup3.c (driver5)."""
    assert lookup3(text) == checksum


def test_of_a_file_that_was_left_open_only_the_superblock_is_shown_otherwise(cut: Path) -> None:
    content = cut.read_bytes()
    with LeftOpen(BytesIO(content)) as left:
        assert left.is_marked
        shown = left.read()
        left.seek(20)
        assert left.read(100) == shown[20:120]
    assert [shown[11], content[11] & 4] == [0, 4]
    assert int.from_bytes(shown[28:36], "little") == len(content)
    assert shown[48:] == content[48:]


def test_a_closed_file_and_a_torn_superblock_are_shown_as_they_are(cut: Path) -> None:
    content = bytearray(cut.read_bytes())
    content[30] ^= 1
    for other in (bytes(content), b"", b"nothing"):
        with LeftOpen(BytesIO(other)) as left:
            assert not left.is_marked
            assert left.read() == other


def test_counts_whose_edge_times_the_disk_has_lost_are_not_believed(cut: Path) -> None:
    """Edge times are written before counts: a program that was killed never leaves a count without its time."""
    content = cut.read_bytes()
    first = content.rindex(EDGES[6:12].tobytes())
    cut.write_bytes(content[:first] + np.full(6, np.nan).tobytes() + content[first + 48 :])
    with pytest.raises(InputError, match="a power cut has left half written"):
        open_recording(cut)


def test_a_frame_that_was_being_written_when_its_program_was_killed_is_no_torn_one(cut: Path) -> None:
    content = cut.read_bytes()
    first = content.rindex(VALUES[294:300].tobytes())
    cut.write_bytes(content[:first] + np.full(6, np.nan).tobytes() + content[first + 48 :])
    recording = open_recording(cut)
    assert np.flatnonzero(~recording.frame_valid).tolist() == [49]


def test_raw_counts_that_were_not_placed_yet_are_recovered_and_are_no_patterns(tmp_path: Path) -> None:
    (tmp_path / "cut").mkdir()
    kept = Keeper(RecordingWriter(tmp_path / "run.h5", PLAN, picture_time_s=50e-6))
    kept.raw(CountBlock(0, VALUES[:100]))
    kept.wait_until_written()
    for file in (tmp_path / "run.h5", journal_of(tmp_path / "run.h5")):
        (tmp_path / "cut" / file.name).write_bytes(file.read_bytes())
    kept.finish(frame_valid=np.ones(0, bool), report="{}")
    done = recover(tmp_path / "cut" / "run.h5")
    assert done is not None
    assert (done.patterns, done.joined) == (0, 0)
    assert len(raw_counts(tmp_path / "cut" / "run.h5").counts) == 100


def test_what_a_run_fills_in_at_its_end_is_recovered_from_the_journal(tmp_path: Path) -> None:
    """Power that is cut when the end is written: the journal has mask, report and truth too, as it is written first."""
    path, failing = tmp_path / "run.h5", [False]

    def sync(_: int) -> None:
        if failing[0]:
            raise OSError("the power is off")

    writer = RecordingWriter(path, PLAN, picture_time_s=50e-6, with_truth=True, sync=sync)
    kept = Keeper(writer, sync_s=1e6)
    kept.raw(CountBlock(0, VALUES))
    kept.placed(VALUES, EDGES)
    kept.wait_until_written()
    failing[0] = True
    truth = Truth(displacement_px=np.arange(200.0).reshape(100, 2), image=np.eye(8))
    assert kept.finish(frame_valid=np.arange(100) != 7, report="{}", truth=truth) is not None
    path.write_bytes(b"")
    assert recover(path) is not None
    recording = open_recording(path)
    assert np.flatnonzero(~recording.frame_valid).tolist() == [7]
    assert recording.truth is not None
    np.testing.assert_array_equal(recording.truth.displacement_px, truth.displacement_px)
    np.testing.assert_array_equal(recording.truth.image, np.eye(8))


def test_a_journal_whose_empty_recording_points_elsewhere_is_refused(cut: Path, tmp_path: Path) -> None:
    secret = tmp_path / "secret.h5"
    with plain.opened(secret, "w") as file:
        file["numbers"] = np.arange(3)
    planted = tmp_path / "planted.h5"
    with RecordingWriter(planted, PLAN, picture_time_s=50e-6) as writer:
        writer.append(VALUES[:6])
        writer.finish()
    plain.link(planted, "entry/notes", secret, "/numbers")
    run = read_spill(journal_of(cut)).run
    Journal(cut, run, planted.read_bytes(), []).close()
    (real,) = (path for path in cut.parent.glob("*.spill") if path.stat().st_mode & 0o077)
    real.unlink()
    before = cut.read_bytes()
    with pytest.raises(InputError, match=r"/entry/notes is a link into another file"):
        recover(cut)
    assert cut.read_bytes() == before
