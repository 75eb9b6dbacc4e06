"""The typed face of h5py: what is stored, what comes back, and what a file that was cut off says."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from instrument.storage.hdf5_file import File, is_hdf5, open_to_read
from instrument.storage.json_text import json_text
from tests.support import plain_hdf5 as plain


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "a.h5"


def test_values_come_back_as_what_they_are_and_truth_as_bytes(path: Path) -> None:
    with File(path, "w") as file:
        entry = file.group("entry", "NXentry", default="data", complete=False)
        entry.add("flags", np.array([True, False]), units="none")
        entry.add_all({"title": "a run", "rate": 12.5, "simulated": True})
    with File(path, "r") as file:
        entry = file.at("entry")
        assert entry.text("title") == "a run"
        assert entry.number("rate") == 12.5
        assert entry.array("flags").tolist() == [1, 0]
        assert entry.array("flags").dtype == np.uint8
        assert entry.number("simulated") == 1.0
        assert (entry.attribute("NX_class"), entry.attribute("default"), entry.attribute("none")) == (
            "NXentry",
            "data",
            None,
        )
        assert entry.attribute_of("flags", "units") == "none"
        assert ("title" in entry, "nothing" in entry) == (True, False)


def test_rows_grow_as_needed_and_what_was_not_written_is_nan(path: Path) -> None:
    with File(path, "w") as file:
        file.growing("rows", (2,), 4, units="px")
        rows = file.rows("rows")
        assert (len(rows), rows.width) == (0, 2)
        rows.write(1, np.array([[1.0, 2.0]]))
        rows.write(0, np.array([[5.0, 6.0]]))
        assert len(rows) == 2, "writing before the end does not shorten it"
        rows.write(3, np.array([[7.0, 8.0]]))
        np.testing.assert_array_equal(rows.read(), [[5, 6], [1, 2], [np.nan, np.nan], [7, 8]])
        file.growing("cube", (2, 3), 4)
        file.growing("line", (), 4)
        assert (file.rows("cube").width, file.rows("line").width) == (6, 1)
        file.add_numbers_to_come("flags", 4, np.uint8)
        flags = file.rows("flags")
        flags.write(1, np.ones(1, np.uint8))
        assert flags.read().tolist() == [0, 1]


def test_a_text_to_come_takes_as_many_bytes_as_it_has_room_for(path: Path) -> None:
    """Four bytes: two letters of two bytes each, and no third."""
    with File(path, "w") as file:
        file.add_text_to_come("why", 4)
        assert file.text("why") == ""
        file.set_value("why", "µµ")
        assert file.text("why") == "µµ"
        with pytest.raises(ValueError, match="5 bytes for why, which has room for 4"):
            file.set_value("why", "µµ!")
        assert file.text("why") == "µµ"


def test_a_group_is_copied_with_its_attributes_and_without_one_child(path: Path, tmp_path: Path) -> None:
    with File(path, "w") as old, File(tmp_path / "b.h5", "w") as new:
        group = old.group("entry", "NXentry", default="data")
        group.add("kept", 1.0)
        group.add("left", 2.0)
        group.copy_to(new.group("entry", "NXother"), without="left")
        assert new.at("entry").attribute("NX_class") == "NXentry"
        assert new.number("entry/kept") == 1.0
        assert "entry/left" not in new


def test_closing_is_allowed_twice_and_leaving_closes(path: Path) -> None:
    with File(path, "w") as file:
        opened = file.is_open
    assert (opened, file.is_open) == (True, False)
    file.close()
    assert is_hdf5(path)


def _left_open(path: Path, rows: int) -> Path:
    """Copy a file as it is while its writer has it open for others to read."""
    copy = path.with_name("copy.h5")
    with File(path, "w") as file:
        file.growing("rows", (1000,), 1)
        growing = file.rows("rows")
        file.let_others_read()
        growing.write(0, np.ones((rows, 1000)))
        shutil.copy(path, copy)
    return copy


def test_what_a_writer_left_open_is_read_as_far_as_it_goes(path: Path) -> None:
    with open_to_read(_left_open(path, 3)) as file:
        assert file.array("rows").shape == (3, 1000)


@pytest.mark.parametrize("lost_bytes", [1, 4000])
def test_a_file_that_lost_its_end_says_where_it_should_be(path: Path, lost_bytes: int) -> None:
    """HDF5 gives zeros for chunks that are not there. Rows of 8,000 bytes: the last one ends where the file does."""
    copy = _left_open(path, 3)
    whole = copy.read_bytes()
    copy.write_bytes(whole[:-lost_bytes])
    with (
        pytest.raises(OSError, match=rf"truncated: .*byte \d+, the file ends at {len(whole) - lost_bytes}"),
        open_to_read(copy) as file,
    ):
        file.array("rows")


def test_a_superblock_that_is_cut_off_is_no_file(path: Path) -> None:
    copy = _left_open(path, 1)
    copy.write_bytes(copy.read_bytes()[:30])
    with pytest.raises(OSError, match=r"truncated|Unable"), open_to_read(copy):
        pass


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no flock")
@pytest.mark.parametrize(
    ("version", "missing_bytes", "refused"),
    [(2, 1, True), (3, 1, True), (3, 0, False), (1, 1, False)],
)
def test_a_locked_file_that_lost_its_end_is_told_by_its_superblock(
    path: Path, version: int, missing_bytes: int, *, refused: bool
) -> None:
    """Versions 2 and 3 hold the end in bytes 28 to 35 (HDF5 file format specification, II.A); 1 holds it elsewhere."""
    import fcntl

    superblock = b"\x89HDF\r\n\x1a\n" + bytes([version]) + bytes(19) + (1000).to_bytes(8, "little")
    path.write_bytes(superblock.ljust(1000 - missing_bytes, b"\0"))
    with path.open("rb") as holder:
        fcntl.flock(holder, fcntl.LOCK_EX)
        with pytest.raises(OSError, match=r"truncated|lock") as caught, open_to_read(path):
            pass
    assert (str(caught.value) == "truncated: it goes on to byte 1000, the file ends at 999") is refused


def test_a_file_that_holds_no_hdf5_is_told(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("no recording")
    assert not is_hdf5(tmp_path / "notes.txt")
    with pytest.raises(OSError, match="signature"), open_to_read(tmp_path / "notes.txt"):
        pass


def test_json_of_numpy_nested_and_not_finite() -> None:
    value = {
        "a": np.float64(0.5),
        2: [np.int64(3), (True, None), float("inf")],
        "rows": np.array([[1.0, np.nan], [-np.inf, 2.0]]),
        "text": "µ",
    }
    assert (
        json_text(value)
        == '{"a": 0.5, "2": [3, [true, null], null], "rows": [[1.0, null], [null, 2.0]], "text": "\\u00b5"}'
    )
    assert json_text({"a": 1}, indent=2) == '{\n  "a": 1\n}'


def test_files_are_in_the_oldest_format_that_can_be_read_while_written(path: Path) -> None:
    """Superblock version 3 of HDF5 1.10, and a group that h5py alone reads."""
    with File(path, "w") as file:
        file.group("entry", "NXentry")
    assert path.read_bytes()[8] == 3
    assert plain.attribute(path, "entry", "NX_class") == "NXentry"
