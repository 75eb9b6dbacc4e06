"""An analysis goes into the recording that it was made from, and nothing else changes."""

import json
from pathlib import Path

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.storage import RecordingWriter, stored_analysis, write_analysis
from protocols import CountBlock, InputError
from tests.support import plain_hdf5 as plain

PLAN = Plan(frames=4, image_size=8)
TRACK = np.array([[0.0, 0.0], [1.0, -0.5], [2.0, -1.0], [np.nan, np.nan]])
IMAGE = np.arange(64.0).reshape(8, 8)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "run.h5"
    counts = np.arange(24)
    with RecordingWriter(path, PLAN, picture_time_s=50e-6, bench='{"scene": null}') as writer:
        writer.append_raw(CountBlock(first_bin=0, counts=counts.astype(np.uint32)))
        writer.append(counts.astype(np.float64), counts * np.float64(50e-6))
        writer.finish(report='{"gaps": []}')
    return path


def everything(path: Path) -> dict[str, tuple[object, object]]:
    """Each dataset outside the analysis: bytes and attributes."""
    found: dict[str, tuple[object, object]] = {}
    with plain.opened(path) as file:

        def visit(name: str, item: object) -> None:
            if hasattr(item, "shape") and not name.startswith("entry/analysis"):
                data = file[name]
                found[name] = (np.asarray(data[()]).tobytes() if data.dtype.kind != "O" else data[()], list(data.attrs))

        file.visititems(visit)
    return found


def test_the_analysis_is_written_beside_untouched_raw_data(path: Path) -> None:
    before = everything(path)
    assert len(before) == 22

    write_analysis(
        path,
        displacement_px=TRACK,
        image=IMAGE,
        sigma_px=0.1 * TRACK,
        table={"psnr_db": np.float64(24.5)},
        settings={"filter": 5},
    )

    assert everything(path) == before
    np.testing.assert_array_equal(plain.array(path, "entry/analysis/track/displacement_px"), TRACK)
    np.testing.assert_array_equal(plain.array(path, "entry/analysis/track/sigma_px"), 0.1 * TRACK)
    np.testing.assert_array_equal(plain.array(path, "entry/analysis/image/image"), IMAGE)
    assert json.loads(plain.text(path, "entry/analysis/table")) == {"psnr_db": 24.5}
    assert json.loads(plain.text(path, "entry/analysis/settings")) == {"filter": 5}


def test_a_second_analysis_replaces_the_first_and_the_file_does_not_grow(path: Path) -> None:
    write_analysis(path, displacement_px=TRACK, image=IMAGE, sigma_px=TRACK)
    size = path.stat().st_size
    write_analysis(path, displacement_px=2 * TRACK, image=-IMAGE)
    np.testing.assert_array_equal(plain.array(path, "entry/analysis/image/image"), -IMAGE)
    with plain.opened(path) as file:
        assert "sigma_px" not in file["entry/analysis/track"]
    assert path.stat().st_size <= size


def test_an_analysis_that_fails_leaves_the_file_as_it_was(path: Path) -> None:
    write_analysis(path, displacement_px=TRACK, image=IMAGE)
    before = path.read_bytes()
    with pytest.raises(TypeError, match="Path cannot be stored as JSON"):
        write_analysis(path, displacement_px=TRACK, image=-IMAGE, table={"file": Path("x")})
    with pytest.raises(ValueError, match="for 4 frames"):
        write_analysis(path, displacement_px=TRACK[:2], image=IMAGE)
    with pytest.raises(ValueError, match="sigma_px of shape"):
        write_analysis(path, displacement_px=TRACK, image=IMAGE, sigma_px=TRACK[:2])
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_a_file_that_is_no_recording_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("no recording")
    with pytest.raises(InputError, match=r"something else than an HDF5 file: .*notes\.txt"):
        write_analysis(path, displacement_px=TRACK, image=IMAGE)
    assert path.read_text() == "no recording"


def test_a_figure_that_is_not_finite_is_null_so_that_the_table_stays_json(path: Path) -> None:
    table = {"ssim": float("nan"), "sigma": [np.inf, np.float64(0.5)], "frames": np.int64(8), "note": None}
    write_analysis(path, displacement_px=TRACK, image=IMAGE, table=table)
    stored = json.loads(plain.text(path, "entry/analysis/table"), parse_constant=pytest.fail)
    assert stored == {"ssim": None, "sigma": [None, 0.5], "frames": 8, "note": None}


def test_how_the_object_turned_and_grew_is_stored_with_its_path(path: Path) -> None:
    part = np.linspace(0.0, 1.0, 4)
    write_analysis(
        path,
        displacement_px=TRACK,
        image=IMAGE,
        angle_deg=3 * part,
        angle_sigma_deg=0.5 * part,
        magnification=1 + 0.03 * part,
        magnification_sigma=0.004 * part,
        pivot_px=np.array([3.5, 4.0]),
    )
    stored = stored_analysis(path)
    assert stored is not None
    for found, expected in (
        (stored.angle_deg, 3 * part),
        (stored.angle_sigma_deg, 0.5 * part),
        (stored.magnification, 1 + 0.03 * part),
        (stored.magnification_sigma, 0.004 * part),
    ):
        np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(plain.array(path, "entry/analysis/track/pivot_px"), [3.5, 4.0])
    with plain.opened(path) as file:
        track = file["entry/analysis/track"]
        assert track["angle_deg"].attrs["units"] == "degree"
        assert "units" not in track["magnification"].attrs


def test_what_json_does_not_know_is_refused(path: Path) -> None:
    with pytest.raises(TypeError, match="complex cannot be stored"):
        write_analysis(path, displacement_px=TRACK, image=IMAGE, table={"z": 1j})
