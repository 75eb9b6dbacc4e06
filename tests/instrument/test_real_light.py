"""Benches whose light is not ideal, analysed as they are: leak, edge loss, dead time, a background."""

import json
from pathlib import Path
from typing import Any

import pytest

from instrument.analysis import Analysis, analyse
from instrument.cli.main import status
from instrument.plan import MotionPlan, Plan
from instrument.session import Instrument, simulate
from instrument.storage import open_recording
from protocols import InputError
from tests.support.benches import bench_toml, plan_toml
from tests.support.plain_hdf5 import array, text

PLAN = Plan(frames=1000, motion=MotionPlan(velocity_mm_s=35.0))
"""60 px along the diagonal in 0.3 s."""


def _analysed(**scene: Any) -> Analysis:
    noise = {"kind": "pixel", "sigma": 0.1, "seed": 1}
    return analyse(simulate(PLAN, {"start_px": [32.3, 32.4], "noise": noise, **scene}), grid="1")


@pytest.fixture(scope="module")
def ideal() -> Analysis:
    return _analysed()


def _as_good_as(found: Analysis, ideal: Analysis, *, worse_db: float) -> None:
    assert found.figures.displacement_mse_px2 is not None
    assert found.figures.displacement_mse_px2 < 0.02
    assert found.figures.psnr_db is not None
    assert ideal.figures.psnr_db is not None
    assert found.figures.psnr_db > ideal.figures.psnr_db - worse_db
    assert found.figures.background_share is None


@pytest.mark.parametrize(("transition_s", "leak"), [(4e-6, 0.04), (12.5e-6, 0.125)])
def test_mirrors_in_transition_are_seen_and_taken_back(ideal: Analysis, transition_s: float, leak: float) -> None:
    found = _analysed(mirror_transition_s=transition_s)
    _as_good_as(found, ideal, worse_db=1.0)
    assert found.light.leak.source == "fitted"
    assert found.light.leak.value == pytest.approx(leak, abs=0.006)
    assert found.light.edge_loss.value == 0


def test_light_lost_at_edges_is_seen_and_taken_back(ideal: Analysis) -> None:
    found = _analysed(edge_loss=0.05)
    _as_good_as(found, ideal, worse_db=1.0)
    assert found.light.edge_loss.source == "fitted"
    assert found.light.edge_loss.value == pytest.approx(0.05, abs=0.01)
    assert found.light.leak.value == 0


def test_both_at_once_are_told_apart(ideal: Analysis) -> None:
    found = _analysed(edge_loss=0.05, mirror_transition_s=12.5e-6)
    _as_good_as(found, ideal, worse_db=1.5)
    assert found.light.leak.value == pytest.approx(0.125, abs=0.006)
    assert found.light.edge_loss.value == pytest.approx(0.05, abs=0.012)


def test_an_ideal_bench_is_found_to_be_one(ideal: Analysis) -> None:
    assert (ideal.light.leak.value, ideal.light.edge_loss.value, ideal.light.ripples) == (0, 0, ())
    assert ideal.figures.background_share is None
    assert ideal.figures.displacement_mse_px2 is not None
    assert ideal.figures.displacement_mse_px2 < 0.01


def test_a_paralyzable_detector_at_forty_million_photons_a_second_is_one_when_the_bench_says_so(tmp_path: Path) -> None:
    """20 ns: at 2,000 photons a pattern N tau / T is 0.8, close to where counts fall again; half of them come as a rule."""
    noise = 'noise = { kind = "poisson", peak_counts = 2000, dead_time_s = 20e-9, dead_time_kind = "paralyzable", seed = 1 }'
    found: list[Analysis] = []
    for name, light in (("silent", ""), ("stated", '[light]\ndead_time_kind = "paralyzable"')):
        (tmp_path / name).mkdir()
        with Instrument.from_toml(bench_toml(tmp_path / name, f"{noise}\n{light}")) as bench:
            found.append(analyse(bench.run(PLAN, tmp_path / name / "run.h5"), grid="1"))
    silent, stated = (analysis.figures for analysis in found)
    assert silent.displacement_mse_px2 is not None
    assert stated.displacement_mse_px2 is not None
    assert stated.displacement_mse_px2 < 0.02
    assert stated.displacement_mse_px2 < silent.displacement_mse_px2 / 4
    assert silent.psnr_db is not None
    assert stated.psnr_db is not None
    assert stated.psnr_db > max(silent.psnr_db + 3, 30)


def test_a_background_that_nobody_measured_is_separated_by_the_command(tmp_path: Path) -> None:
    scene = 'background = "letter-I"\nnoise = { kind = "poisson", peak_counts = 1000, seed = 2 }'
    bench, plan, path = bench_toml(tmp_path, scene), plan_toml(tmp_path, PLAN), tmp_path / "run.h5"
    assert status(["run", "--bench", str(bench), "--plan", str(plan), "--out", str(path)]) == 0
    assert status(["analyse", str(path)]) == 0
    table = json.loads(text(path, "/entry/analysis/table"))
    truth = open_recording(path).truth
    assert truth is not None
    assert table["background_share"] == pytest.approx(324 / (324 + 827), abs=0.06)  # pixels of both letters
    assert table["displacement_mse_px2"] < 0.05
    assert table["psnr_db"] > 26
    assert array(path, "/entry/analysis/background/background").shape == (128, 128)


def test_more_counts_than_a_paralyzable_detector_can_give_are_refused_by_name(tmp_path: Path) -> None:
    noise = 'noise = { kind = "poisson", peak_counts = 4000, dead_time_s = 20e-9, seed = 1 }'
    light = '[light]\ndead_time_kind = "paralyzable"'
    with Instrument.from_toml(bench_toml(tmp_path, f"{noise}\n{light}")) as bench:
        recording = bench.run(PLAN, tmp_path / "run.h5")
    with pytest.raises(InputError, match="paralyzable detector with a dead time of 20 ns"):
        analyse(recording)
