"""Other programs' files, the log, and what the command says besides."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from instrument.cli.main import status
from instrument.plan import Plan
from instrument.session import Instrument
from instrument.storage import open_recording
from tests.support.benches import SMALL, bench_toml, plan_toml
from tests.support.plans import plan_of


def run(folder: Path, name: str, plan: Plan = SMALL) -> Path:
    with Instrument.from_toml(bench_toml(folder, 'object = "letter-B"')) as bench:
        bench.run(plan, folder / name)
    return folder / name


FAST = ("--tracking", "per-frame", "--method", "conventional", "--no-pictures")


def test_two_recordings_are_compared_by_their_whole_names_and_equal_ones_are_told_to_be(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "day").mkdir()
    run(tmp_path / "day", "a.h5")
    monkeypatch.chdir(tmp_path)
    assert status(["compare", "day/a.h5", "day/a.h5", "--picture", "both.svg"]) == 0
    said = capsys.readouterr().out
    assert "day/a.h5 against day/a.h5" in said
    assert "both images are equal, to the last digits" in said
    assert "300" not in said
    assert (tmp_path / "both.svg").read_text().startswith("<?xml")


@pytest.mark.parametrize(
    ("scheme", "given", "why"),
    [
        ("fourier-3step", "--method tv", "which makes no image"),
        ("hadamard", "--tracking smooth", "which sees no position"),
    ],
)
def test_an_option_that_does_nothing_for_the_scheme_is_told(
    scheme: str, given: str, why: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = run(tmp_path, "run.h5", plan_of(scheme, 40, 32))
    capsys.readouterr()
    assert status(["analyse", str(file), "--no-pictures", "--json", *given.split()]) == 0
    said = capsys.readouterr()
    told = f"{given.split(maxsplit=1)[0]} does nothing for the scheme {scheme}, {why}"
    assert told in said.err
    assert told in json.loads(said.out)["warnings"]
    assert status(["analyse", str(file), "--no-pictures", "--json"]) == 0
    assert "does nothing" not in capsys.readouterr().err


def test_pictures_are_written_as_asked(tmp_path: Path) -> None:
    file = run(tmp_path, "run.h5")
    assert status(["analyse", str(file), *FAST[:4], "--format", "svg", "--pictures", str(tmp_path / "drawn")]) == 0
    assert (tmp_path / "drawn" / "run-summary.svg").read_text().startswith("<?xml")
    assert list((tmp_path / "drawn").glob("*.png")) == []


def test_a_recording_is_exported_for_other_programs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = run(tmp_path, "run.h5")
    assert status(["analyse", str(file), *FAST]) == 0
    before = file.read_bytes()
    assert status(["export", str(file), "--csv", "--tiff", "--npz"]) == 0
    assert file.read_bytes() == before
    recording = open_recording(file)
    with (tmp_path / "run.csv").open(newline="") as opened:
        rows = list(csv.DictReader(opened))
    assert list(rows[0])[:9] == ["frame", "time_s", "frame_valid", *(f"values_{k}" for k in range(6))]
    assert {"x_px", "y_px", "sigma_x_px", "truth_x_px"} <= set(rows[0])
    assert [float(rows[7][f"values_{k}"]) for k in range(6)] == recording.values[7].tolist()
    with np.load(tmp_path / "run.npz") as arrays:
        assert arrays["values"].tolist() == recording.values.tolist()
        image = arrays["image"]
        assert float(rows[39]["x_px"]) == arrays["displacement_px"][39, 0]
    with Image.open(tmp_path / "run.tiff") as picture:
        assert picture.mode == "F"
        assert np.asarray(picture).tolist() == image.astype(np.float32).tolist()
    capsys.readouterr()
    assert status(["export", str(file), "--csv"]) == 2
    assert "run.csv, which exists" in capsys.readouterr().err
    assert status(["export", str(file), "--csv", "--overwrite"]) == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "no kind of file"),
        (["--csv", "--npz", "--out", "x"], "--csv and --npz with one --out"),
        (["--tiff"], "no reconstructed image"),
        (["--csv", "--out", "nowhere/x.csv"], "no folder nowhere"),
    ],
)
def test_what_cannot_be_exported_is_refused(
    arguments: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = run(tmp_path, "run.h5")
    monkeypatch.chdir(tmp_path)
    assert status(["export", str(file), *arguments]) == 2
    assert said in capsys.readouterr().err


def test_an_image_of_as_many_rows_as_there_are_frames_is_no_column(tmp_path: Path) -> None:
    file = run(tmp_path, "run.h5", plan_of("fourier-hadamard", 32, 32))
    assert status(["analyse", str(file), *FAST, "--grid", "1"]) == 0
    assert status(["export", str(file), "--csv", "--npz"]) == 0
    with np.load(tmp_path / "run.npz") as arrays:
        assert arrays["image"].shape == arrays["truth_image"].shape == (32, 32)
    columns = (tmp_path / "run.csv").read_text().splitlines()[0].split(",")
    assert [name for name in columns if "image" in name or "edge" in name] == []
    assert columns[-2:] == ["truth_x_px", "truth_y_px"]


def test_a_film_into_a_folder_that_is_not_there_is_refused_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = run(tmp_path, "run.h5")
    assert status(["film", str(file), "--out", str(tmp_path / "nowhere" / "a.gif")]) == 2
    assert "an existing folder for a.gif" in capsys.readouterr().err


def test_a_recording_without_analysis_is_exported_as_it_is(tmp_path: Path) -> None:
    file = run(tmp_path, "run.h5")
    assert status(["export", str(file), "--csv", "--out", str(tmp_path / "values.txt")]) == 0
    head = (tmp_path / "values.txt").read_text().splitlines()[0]
    assert (
        head == "frame,time_s,frame_valid,values_0,values_1,values_2,values_3,values_4,values_5,truth_x_px,truth_y_px"
    )


def test_a_run_without_a_name_gets_one_of_its_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert status(["run", "--bench", str(bench_toml(tmp_path)), "--plan", str(plan_toml(tmp_path)), "--json"]) == 0
    name = json.loads(capsys.readouterr().out)["recording"]
    assert re.fullmatch(r"run-\d{8}-\d{6}\.h5", name)
    assert len(open_recording(tmp_path / name)) == 40


def test_the_log_has_what_was_asked_told_and_found(tmp_path: Path) -> None:
    log, bench, plan = tmp_path / "bench.log", bench_toml(tmp_path), plan_toml(tmp_path)
    run = ["run", "--bench", str(bench), "--plan", str(plan), "--out", str(tmp_path / "run.h5")]
    assert status(["--log", str(log), *run]) == 0
    assert status(["--log", str(log), *run]) == 2
    lines = log.read_text().splitlines()
    assert all(
        re.match(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z (INFO|WARNING|ERROR) kinopix: ", line) for line in lines
    )
    said = "\n".join(lines)
    assert lines[0].endswith(f"kinopix 0.1.0: --log {log} {' '.join(run)}")
    for words in ("run: counting", "run: the run is done; 240 of 240 patterns are kept in", "recorded 40 frames in"):
        assert words in said
    assert "patterns 0 to" not in said
    assert "ERROR kinopix: saw" in lines[-2]
    assert lines[-1].endswith("ended with exit code 2")


def test_a_verbose_log_has_every_block_and_goes_to_standard_error_without_a_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--bench", str(bench_toml(tmp_path)), "--plan", str(plan_toml(tmp_path))]
    assert status(["--verbose", "run", *arguments, "--out", str(tmp_path / "run.h5")]) == 0
    assert "DEBUG kinopix: run: patterns 0 to 239" in capsys.readouterr().err
    assert status(["--log", str(tmp_path / "no" / "log"), "drivers"]) == 2
    assert "which cannot be written: No such file or directory" in capsys.readouterr().err
