"""``kinopix run --live`` on simulated devices."""

from pathlib import Path

import pytest

from instrument.cli.main import status
from tests.support.benches import bench_toml, plan_toml


def test_live_prints_figures_beside_the_recording(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench = bench_toml(tmp_path, 'object = "letter-B"')
    arguments = ["run", "--live", "--bench", bench, "--plan", plan_toml(tmp_path), "--out", tmp_path / "run.h5"]
    assert status([str(argument) for argument in arguments]) == 0
    said = capsys.readouterr()
    assert "frame 40: x " in said.err
    assert "0 frames dropped" in said.err
    assert "recorded 40 frames" in said.out


def test_a_live_view_that_fails_is_told_and_the_run_ends_well(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("no terminal left")

    monkeypatch.setattr("instrument.views.live.LiveView.show", broken)
    bench = bench_toml(tmp_path, 'object = "letter-B"')
    arguments = ["run", "--live", "--bench", bench, "--plan", plan_toml(tmp_path), "--out", tmp_path / "run.h5"]
    assert status([str(argument) for argument in arguments]) == 0
    said = capsys.readouterr()
    assert "the live view ended early, the recording did not: no terminal left" in said.err
    assert "recorded 40 frames" in said.out
