"""Numbers that were changed after the run are found at every reading, with their frames."""

import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.plan import Plan
from instrument.storage import RecordingWriter, open_recording, write_analysis
from instrument.storage.checksum import Checksums, changed_frames
from protocols import InputError
from tests.support import plain_hdf5 as plain

PLAN = Plan(frames=250, image_size=8)
VALUES = np.arange(1497, dtype=np.float64)
"""Of 249 frames and a half."""
ROWS = np.append(VALUES, [np.nan] * 3).reshape(250, 6)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "run.h5"
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        for part in np.split(VALUES, [7, 600, 601, 1400]):
            writer.append(part, part * 50e-6)
        writer.finish()
    return path


def test_the_checksums_are_those_of_zlib(path: Path) -> None:
    expected = [zlib.crc32(ROWS[first : first + 100].astype("<f8").tobytes()) for first in (0, 100, 200)]
    np.testing.assert_array_equal(plain.array(path, "entry/checksum/values"), expected)
    edges = [zlib.crc32((ROWS[first : first + 100] * 50e-6).astype("<f8").tobytes()) for first in (0, 100, 200)]
    np.testing.assert_array_equal(plain.array(path, "entry/checksum/edges"), edges)
    assert open_recording(path).values.shape == (250, 6)


@pytest.mark.parametrize(
    ("frame", "told"), [(0, "frames 0 to 99"), (199, "frames 100 to 199"), (249, "frames 200 to 249")]
)
@pytest.mark.parametrize(("name", "what"), [("values", "values"), ("edge_time_s", "edge times")])
def test_a_number_that_was_changed_is_told_with_its_frames(
    path: Path, frame: int, told: str, name: str, what: str
) -> None:
    """By the last bit of one number."""
    with plain.opened(path, "r+") as file:
        data = file["entry/data"][name]
        data[frame, 2] = np.nextafter(data[frame, 2], np.inf)
    with pytest.raises(InputError, match=f"{what} of {told} that were changed after the run"):
        open_recording(path)
    with pytest.raises(InputError, match="changed after the run"):
        write_analysis(path, displacement_px=np.ones((250, 2)), image=None)
    with plain.opened(path, "r+") as file:
        del file["entry/checksum"]
    assert len(open_recording(path)) == 250


def test_all_changed_frames_are_counted() -> None:
    sums = Checksums(6)
    sums.add(ROWS.ravel())
    changed = ROWS.copy()
    changed[[0, 220]] = 0
    assert changed_frames(ROWS, sums.finished()) == ""
    assert changed_frames(changed, sums.finished()) == "frames 0 to 99 (and 1 more such block)"
    assert changed_frames(ROWS[:99], sums.finished()) == "99 frames, where checksums stand for 3 times 100"


@given(st.lists(st.integers(0, 1497), max_size=5))
def test_checksums_do_not_depend_on_how_numbers_come(cuts: list[int]) -> None:
    whole, parts = Checksums(6), Checksums(6)
    whole.add(VALUES)
    for part in np.split(VALUES, sorted(cuts)):
        parts.add(part)
    np.testing.assert_array_equal(whole.finished(), parts.finished())
    assert len(whole.finished()) == 3


def test_an_analysis_keeps_the_checksums(path: Path) -> None:
    before = plain.array(path, "entry/checksum/values")
    write_analysis(path, displacement_px=np.ones((250, 2)), image=None)
    np.testing.assert_array_equal(plain.array(path, "entry/checksum/values"), before)
    assert len(open_recording(path)) == 250
