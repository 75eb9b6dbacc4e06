"""The lab script moves the stage and records a run from each place."""

import runpy
from pathlib import Path

import pytest

from instrument.storage import open_recording
from tests.support.benches import SMALL, bench_toml, plan_toml

SCRIPT = Path(__file__).parents[2] / "examples" / "move_and_acquire.py"


def test_the_script_records_a_run_from_each_starting_point(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "recordings"
    arguments = [
        str(bench_toml(tmp_path)),
        str(plan_toml(tmp_path, SMALL.model_copy(update={"frames": 400}))),
        str(out),
    ]
    monkeypatch.setattr("sys.argv", [str(SCRIPT), *arguments])
    runpy.run_path(str(SCRIPT), run_name="__main__")
    said = capsys.readouterr().out.splitlines()
    assert [line.split(" mm")[0] for line in said] == ["from 0", "from 0.5", "from 1"]
    for start in ("0", "0.5", "1"):
        recording = open_recording(out / f"from-{start}-mm.h5")
        assert recording.plan.motion is not None
        assert recording.plan.motion.start_mm == float(start)
        assert recording.frame_valid.all()


def test_a_plan_without_motion_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = plan_toml(tmp_path, SMALL.model_copy(update={"motion": None}))
    monkeypatch.setattr("sys.argv", [str(SCRIPT), str(bench_toml(tmp_path)), str(plan), str(tmp_path / "out")])
    with pytest.raises(SystemExit, match="nothing to move"):
        runpy.run_path(str(SCRIPT), run_name="__main__")


def test_without_arguments_the_script_says_how_it_is_called(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", [str(SCRIPT)])
    with pytest.raises(SystemExit, match=r"python examples/move_and_acquire\.py bench\.toml plan\.toml"):
        runpy.run_path(str(SCRIPT), run_name="__main__")
