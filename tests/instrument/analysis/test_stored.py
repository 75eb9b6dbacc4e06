"""The analysis of a file, as a script asks for it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from instrument import Instrument
from instrument.analysis import analyse, analyse_path, store
from instrument.storage import open_recording, stored_analysis
from tests.support.benches import SMALL, bench_toml
from tests.support.plain_hdf5 import array


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of 40 frames on a simulated bench."""
    folder = tmp_path_factory.mktemp("run")
    with Instrument.from_toml(bench_toml(folder)) as bench:
        bench.run(SMALL, folder / "run.h5")
    return folder / "run.h5"


def test_figures_are_given_and_path_and_image_are_stored(run: Path) -> None:
    steps_done: list[int] = []

    figures = analyse_path(run, on_step=lambda _what, done, _total: steps_done.append(done))

    found_px, truth_px = array(run, "/entry/analysis/track/displacement_px"), array(run, "/entry/truth/displacement_px")
    assert figures.frames == 40
    assert figures.displacement_mse_px2 == pytest.approx(np.mean((found_px - truth_px) ** 2))
    assert array(run, "/entry/analysis/image/image").shape == (32, 32)
    assert steps_done == [0, 1, 2, 3]


def test_frames_that_were_left_out_are_nan_in_the_file(run: Path) -> None:
    figures = analyse_path(run, frames=25, tracking="per-frame", method="conventional")

    stored_px = array(run, "/entry/analysis/track/displacement_px")
    assert figures.frames == 25
    assert np.isfinite(stored_px[:25]).all()
    assert np.isnan(stored_px[25:]).all()


def test_a_change_of_shape_is_stored_for_all_frames(run: Path, tmp_path: Path) -> None:
    """Of 25 of 40 frames; the rest is not known. A table has it too."""
    pytest.importorskip("pandas")
    recording = open_recording(run)
    analysis = analyse(recording.first(25), tracking="per-frame", method="conventional")
    assert analysis.trajectory is not None
    part = np.arange(25) / 25
    path = replace(
        analysis.trajectory, magnification=1 + part, magnification_sigma=0.1 * part, pivot_px=np.array([3.0, 4.0])
    )
    frame = path.to_dataframe()
    assert frame["magnification"].tolist() == (1 + part).tolist()
    assert frame["sigma_magnification"].tolist() == (0.1 * part).tolist()

    copy = tmp_path / "copy.h5"
    store(run, recording, replace(analysis, trajectory=path), copy)
    stored = stored_analysis(copy)
    assert stored is not None
    assert stored.magnification is not None
    assert stored.magnification_sigma is not None
    np.testing.assert_array_equal(stored.magnification, [*(1 + part), *[np.nan] * 15])
    np.testing.assert_array_equal(stored.magnification_sigma, [*(0.1 * part), *[np.nan] * 15])
    assert array(copy, "/entry/analysis/track/pivot_px").tolist() == [3.0, 4.0]


def test_the_file_says_which_frame_displacements_are_relative_to(run: Path, tmp_path: Path) -> None:
    recording = open_recording(run)
    analysis = analyse(recording, tracking="per-frame", method="conventional")
    assert analysis.trajectory is not None
    later = replace(analysis, trajectory=replace(analysis.trajectory, reference_frame=7))
    store(run, recording, later, tmp_path / "later.h5")
    store(run, recording, analysis, tmp_path / "plain.h5")
    found = [stored_analysis(tmp_path / name) for name in ("later.h5", "plain.h5")]
    assert [one.reference_frame for one in found if one is not None] == [7, 0]
