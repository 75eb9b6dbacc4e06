"""The analysis of a file, as a script asks for it."""

from pathlib import Path

import numpy as np
import pytest

from instrument import Instrument
from instrument.analysis import analyse_path
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
