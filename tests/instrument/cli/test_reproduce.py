"""``kinopix reproduce`` on a tiny study."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from instrument.cli.main import status
from instrument.studies import STUDIES
from tests.instrument.studies import tiny


@pytest.fixture(autouse=True)
def a_tiny_study(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(STUDIES, "noise", tiny.STUDY)


def test_tables_figures_numbers_and_a_page_are_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, docs = tmp_path / "out", tmp_path / "docs"
    command = ["reproduce", "noise", "--seeds", "2", "--workers", "1", "--out", str(out), "--docs", str(docs)]
    code = status(command)
    said = capsys.readouterr().out
    assert code == 0
    assert "Tiny. Mean ± deviation of one seed, seeds 0 to 1" in said
    assert "PSNR, dB" in said
    assert "does not hold" in said
    assert sorted(path.name for path in out.iterdir()) == [
        "noise-images.pdf",
        "noise-images.png",
        "noise-seeds.csv",
        "noise.csv",
        "noise.pdf",
        "noise.png",
        "points",
    ]
    assert len(list((out / "points").iterdir())) == 4
    assert sorted(path.name for path in docs.iterdir()) == ["README.md", "noise-images.png", "noise.md", "noise.png"]
    assert "1.50 | 1.50 ± 0.71 |" in (docs / "noise.md").read_text()
    assert "- [Tiny](noise.md)" in (docs / "README.md").read_text()
    (docs / "README.md").write_text("an index of one's own")
    assert status(command) == 0
    assert (docs / "README.md").read_text() == "an index of one's own"


def test_a_point_that_fails_is_named_after_the_tables(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(STUDIES, "noise", replace(tiny.STUDY, compute=tiny.refuse))
    code = status(["reproduce", "noise", "--seeds", "2", "--workers", "1", "--out", str(tmp_path), "--json"])
    told = capsys.readouterr()
    assert code == 3
    assert "2 points fail: noise: a, 1, seed 1 (ValueError: seed 1 is not liked); noise: a, 2, seed 1" in told.err
    found = json.loads(told.out)["noise"]
    assert found["figures"][1] == {
        "case": "a, 1",
        "processing": "one",
        "figure": "psnr_db",
        "mean": 1.0,
        "deviation": 0.0,
    }
    assert found["claims"][1] == {"text": "never", "holds": False}


def test_an_interrupt_says_what_is_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(STUDIES, "noise", replace(tiny.STUDY, compute=tiny.interrupted))
    assert status(["reproduce", "noise", "--seeds", "2", "--workers", "1", "--out", str(tmp_path)]) == 130
    told = " ".join(capsys.readouterr().err.split())
    assert f"1 finished points are kept in {tmp_path / 'points'}, and the same command goes on from there" in told


def test_what_is_no_study_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert status(["reproduce", "table2"]) == 2
    assert "table2" in capsys.readouterr().err
