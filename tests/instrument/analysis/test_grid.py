"""Which image grid a motion supports, and what a finer image and a background leave in the file."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.analysis import analyse_path
from instrument.joint import grid_of
from instrument.reconstruction import binned
from instrument.storage import RecordingWriter
from instrument.tracking import Trajectory
from protocols import CountBlock, Floats
from tests.instrument.joint.behind import bar, recorded
from tests.support import plain_hdf5 as plain


def _path(x_px: Floats, y_px: Floats, valid: Floats | None = None) -> Trajectory:
    place_px = np.stack([x_px, y_px], axis=1).astype(np.float64)
    mask = np.ones(len(x_px), np.bool_) if valid is None else valid.astype(np.bool_)
    return Trajectory(place_px, np.zeros_like(place_px), 3e-4, "given", mask)


def _quarters(visits: list[int]) -> Floats:
    """Places in the middles of the quarters of pixels, so many of each, one px further every time."""
    quarter = np.repeat(np.arange(4), visits)
    return np.asarray(np.arange(len(quarter)) + quarter / 4 + 0.125, np.float64)


EVERY = _quarters([16, 16, 16, 16])


def test_sixteen_visits_of_every_quarter_along_both_axes_support_the_finer_grid() -> None:
    assert grid_of(_path(EVERY, EVERY)) == 2
    assert grid_of(_path(-EVERY, EVERY)) == 2
    for quarter in range(4):
        visits = [16] * 4
        visits[quarter], visits[quarter - 1] = 15, 17
        assert grid_of(_path(EVERY, _quarters(visits))) == 1
        assert grid_of(_path(_quarters(visits), EVERY)) == 1


def test_whole_steps_along_one_axis_do_not() -> None:
    assert grid_of(_path(EVERY, np.arange(64.0))) == 1
    assert grid_of(_path(np.zeros(64), EVERY)) == 1


def test_frames_that_were_not_measured_do_not_count() -> None:
    valid = np.arange(64) != 40
    assert grid_of(_path(EVERY, EVERY, valid)) == 1


def test_strong_noise_hides_what_a_finer_grid_would_show() -> None:
    assert grid_of(_path(EVERY, EVERY), penalty=0.39) == 2
    assert grid_of(_path(EVERY, EVERY), penalty=0.4) == 1


def test_binned_by_hand() -> None:
    image = np.array([[0, 4, 1, 1], [8, 0, 1, 1], [2, 2, 0, 0], [2, 2, 0, 1]], np.float64)
    assert binned(image, 2).tolist() == [[3, 1], [2, 0.25]]
    np.testing.assert_array_equal(binned(image, 1), image)


@given(grid=st.integers(1, 4), seed=st.integers(0, 100))
def test_binning_keeps_the_mean_and_undoes_a_repeat(grid: int, seed: int) -> None:
    image = np.random.default_rng(seed).random((6, 5))
    finer = image.repeat(grid, axis=0).repeat(grid, axis=1)
    np.testing.assert_allclose(binned(finer, grid), image)


@pytest.fixture(scope="module")
def analysed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of a run with a background of a third of the object's light, analysed at two image pixels a pattern pixel."""
    path = tmp_path_factory.mktemp("grid") / "run.h5"
    recording = recorded(1 / 3)
    with RecordingWriter(path, recording.plan, picture_time_s=recording.picture_time_s) as writer:
        writer.append_raw(CountBlock(first_bin=0, counts=recording.values.ravel()))
        writer.append(recording.values.ravel())
        writer.finish()
    figures = analyse_path(path, grid="2")
    assert figures.background_share == pytest.approx(0.25, abs=0.04)
    return path


def test_axes_of_a_finer_image_say_where_its_pixels_are(analysed: Path) -> None:
    """The first pattern pixel reaches from -0.5 to 0.5 px: halves of it have their middles at -0.25 and 0.25."""
    group = "entry/analysis/image"
    assert plain.array(analysed, f"{group}/image").shape == (256, 256)
    for axis in ("x_px", "y_px"):
        places = plain.array(analysed, f"{group}/{axis}")
        np.testing.assert_allclose(places, -0.25 + 0.5 * np.arange(256))
    assert float(plain.array(analysed, f"{group}/pixel_px")) == 0.5


def test_a_background_that_was_found_is_in_the_file_on_the_patterns_grid(analysed: Path) -> None:
    group = "entry/analysis/background"
    still = plain.array(analysed, f"{group}/background")
    assert still.shape == (128, 128)
    assert plain.attribute(analysed, group, "signal") == "background"
    assert float(plain.array(analysed, f"{group}/pixel_px")) == 1.0
    np.testing.assert_allclose(plain.array(analysed, f"{group}/x_px"), np.arange(128))
    found = still[14:46, 82:94].mean()
    assert found == pytest.approx(bar(1 / 3).max(), rel=0.1)
    assert np.abs(still[70:, :60]).mean() < 0.02


def test_where_none_was_found_none_is_in_the_file(tmp_path: Path) -> None:
    recording = recorded(0.0)
    path = tmp_path / "run.h5"
    with RecordingWriter(path, recording.plan, picture_time_s=recording.picture_time_s) as writer:
        writer.append_raw(CountBlock(first_bin=0, counts=recording.values.ravel()))
        writer.append(recording.values.ravel())
        writer.finish()
    assert analyse_path(path, grid="1").background_share is None
    with plain.opened(path) as file:
        assert "image" in file["entry/analysis"]
        assert "background" not in file["entry/analysis"]
    places = plain.array(path, "entry/analysis/image/x_px")
    np.testing.assert_allclose(places, np.arange(128))
