"""``kinopix calibrate displacement`` as its user types it: measured, written, named, used by the next run."""

import json
from pathlib import Path

import pytest

from instrument.cli.main import status
from instrument.config import read_calibration
from instrument.plan import MotionPlan, Plan
from instrument.storage import open_recording
from tests.support.benches import bench_toml, plan_toml
from tests.support.calibrations import MEASURED_SCENE

SMALL = ["--image-size", "32", "--superpixel", "4", "--frames", "1024"]


def said_of(capsys: pytest.CaptureFixture[str]) -> str:
    """What was printed, on one line."""
    out, err = capsys.readouterr()
    return " ".join((out + err).split())


def test_it_is_measured_written_named_and_used(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench = bench_toml(tmp_path, MEASURED_SCENE)
    arguments = ["calibrate", "displacement", "--bench", str(bench), *SMALL]
    assert status([*arguments, "--positions-mm", "10,14.5,19", "--one-way"]) == 0
    said = said_of(capsys)
    assert "px/mm" in said
    assert "does not name this file yet: add calibration = " in said
    found = read_calibration(tmp_path / "calibration.toml").displacement
    assert found is not None
    assert found.px_per_mm == pytest.approx(2.0, rel=3e-3)
    assert found.axis_angle_deg == pytest.approx(40.0, abs=0.2)
    (folder,) = tmp_path.glob("displacement-*")
    assert [path.name for path in sorted(folder.iterdir())] == ["view-01.h5", "view-02.h5", "view-03.h5"]

    bench.write_text('calibration = "calibration.toml"\n' + bench.read_text())
    motion = MotionPlan(start_mm=1.0, velocity_mm_s=25.0)
    plan = Plan(frames=500, image_size=32, superpixel=4, motion=motion)
    run = ["run", "--bench", str(bench), "--plan", str(plan_toml(tmp_path, plan)), "--out", str(tmp_path / "run.h5")]
    assert status(run) == 0
    assert open_recording(tmp_path / "run.h5").px_per_mm == found.px_per_mm
    capsys.readouterr()
    assert status(["analyse", str(tmp_path / "run.h5"), "--json", "--no-pictures"]) == 0
    figures = json.loads(capsys.readouterr().out)
    speed = figures["motion_mm"]["speed"]
    assert speed["low"] < 25.0 < speed["high"]
    assert figures["stage"]["travel_ratio"]["low"] < 1 < figures["stage"]["travel_ratio"]["high"]

    # The same bench from this moving run, into a file of its own.
    again = [*arguments, "--from", str(tmp_path / "run.h5"), "--out", str(tmp_path / "moving.toml"), "--json"]
    assert status(again) == 0
    of_run = json.loads(capsys.readouterr().out)
    low, high = of_run["px_per_mm_95"]
    assert low < 2.0 < high
    assert of_run["displacement"]["method"] == "moving run"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "neither --positions-mm nor --span-mm"),
        (["--positions-mm", "1,2,3", "--span-mm", "1", "3"], "saw --positions-mm and --span-mm"),
        (["--positions-mm", "1;2;3"], "numbers with commas between them"),
        (["--positions-mm", "1,2"], "expected 3 or more"),
        (["--span-mm", "5", "5"], "two of them 0 mm apart"),
        (["--positions-mm", "10,20,500"], "500.5 mm; expected 0 to 400 mm"),
    ],
)
def test_what_cannot_be_asked_is_said_before_anything_moves(
    tmp_path: Path, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = bench_toml(tmp_path, MEASURED_SCENE)
    assert status(["calibrate", "displacement", "--bench", str(bench), *SMALL, *arguments]) == 2
    assert message in said_of(capsys)
    assert [path.name for path in tmp_path.iterdir()] == ["bench.toml"]


def test_a_file_of_another_bench_is_left_as_it_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = 'version = 1\n[bench.stage]\nvendor = "Zolix"\nmodel = "KA200"\n'
    (tmp_path / "calibration.toml").write_text(text)
    bench = bench_toml(tmp_path, MEASURED_SCENE)
    arguments = [
        "calibrate",
        "displacement",
        "--bench",
        str(bench),
        *SMALL,
        "--positions-mm",
        "10,14.5,19",
        "--one-way",
    ]
    assert status(arguments) == 2
    assert "stage: saw a calibration that was made with Zolix KA200" in said_of(capsys)
    assert (tmp_path / "calibration.toml").read_text() == text
    assert not list(tmp_path.glob("displacement-*")), "refused before the stage has moved"
