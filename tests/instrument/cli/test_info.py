"""``kinopix info`` as a user reads it."""

import json
import shutil
from pathlib import Path

import h5py
import pytest

from instrument.cli.main import status
from tests.support import plain_hdf5 as plain
from tests.support.benches import SMALL, bench_toml, plan_toml

PHOTONS = 'noise = { kind = "poisson", peak_counts = 900, seed = 1 }'


@pytest.fixture(scope="module")
def run_h5(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of 400 frames with its analysis."""
    folder = tmp_path_factory.mktemp("info")
    plan = plan_toml(folder, SMALL.model_copy(update={"frames": 400}))
    out = folder / "run.h5"
    assert status(["run", "--bench", str(bench_toml(folder, PHOTONS)), "--plan", str(plan), "--out", str(out)]) == 0
    assert status(["analyse", str(out), "--no-pictures"]) == 0
    return out


def test_the_table_says_what_the_recording_is(run_h5: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert status(["info", str(run_h5)]) == 0
    said = " ".join(capsys.readouterr().out.replace("│", " ").split())
    for words in (
        "complete",
        "fourier-hadamard, 400 frames",
        "32 x 32 px, 25 mm/s from 0 mm",
        "400 of 400, 0 masked",
        "photon counts, edge times, truth, analysis",
        "good",
        "simulated DLP7000",
        "PSNR",
    ):
        assert words in said


def test_json_holds_the_figures_and_the_plan(run_h5: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert status(["info", str(run_h5), str(run_h5), "--json"]) == 0
    first, second = json.loads(capsys.readouterr().out)["recordings"]
    assert first == second
    assert (first["state"], first["frames"], first["frames_masked"]) == ("complete", 400, 0)
    assert first["plan"]["scheme"]["name"] == "fourier-hadamard"
    assert first["timing"]["verdict"] == "good"
    assert first["devices"]["stage"]["simulated"] is True
    assert first["analysis"]["table"]["psnr_db"] > 10


def test_a_bad_file_among_good_ones_is_named_and_the_others_are_told(
    run_h5: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    (tmp_path / "notes.txt").write_text("no recording")
    assert status(["info", str(tmp_path / "notes.txt"), str(run_h5), "--json"]) == 2
    printed = capsys.readouterr()
    assert "something else than an HDF5 file" in printed.err
    assert "notes.txt" in printed.err
    assert [row["title"] for row in json.loads(printed.out)["recordings"]] == ["run"]


def test_a_recording_whose_scheme_is_not_installed_shows_the_rest(
    run_h5: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    strange = tmp_path / "strange.h5"
    shutil.copy(run_h5, strange)
    with h5py.File(strange, "r+") as file:
        text = plain.text(run_h5, "entry/plan").replace('"fourier-hadamard"', '"of-another-lab"')
        del file["entry/plan"]
        file["entry/plan"] = text
    capsys.readouterr()
    assert status(["info", str(strange)]) == 0
    said = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "scheme 'of-another-lab' is not installed here" in said
    assert "400 of ?, 0 masked" in said
    assert "simulated DLP7000" in said
    assert status(["info", "--json", str(strange)]) == 0
    shown = json.loads(capsys.readouterr().out)["recordings"][0]
    assert (shown["plan"], shown["missing_scheme"], shown["frames"]) == (None, "of-another-lab", 400)
    assert status(["analyse", str(strange)]) == 2
