"""The tutorials, as a newcomer types them, one after the other."""

import re
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from instrument.config import read_calibration
from tests.docs.transcript import Typed, agrees, prepare, printed_by, typed

TUTORIALS = Path(__file__).parents[2] / "docs" / "tutorials"


def follow(page: str, folder: Path) -> int:
    """Do what a page says, in a folder that is the current one; give the number of commands."""
    commands = 0
    names: dict[str, Any] = {}
    for step in typed((TUTORIALS / page).read_text(encoding="utf-8")):
        if isinstance(step, Typed):
            printed = printed_by(step.command)
            assert agrees(step.shown, printed), f"$ {step.command}\n" + "\n".join(printed)
            commands += 1
        else:
            prepare(*step, folder, names)
    return commands


def test_a_picture_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert follow("own-picture.md", tmp_path) == 2
    with Image.open(tmp_path / "own" / "run-summary.png") as picture:
        assert picture.width > 1000


def test_a_bench_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert follow("own-bench.md", tmp_path) == 6


def test_first_light_and_a_figure_for_a_paper(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert follow("first-light.md", tmp_path) > 12
    found = read_calibration(tmp_path / "calibration.toml")
    assert list(found.sections) == ["displacement", "detector", "mirrors", "light", "alignment"]
    assert read_calibration(tmp_path / "emulated-calibration.toml").displacement is not None

    assert follow("figure-for-a-paper.md", tmp_path) == 6
    caption = re.search(
        r"The speed is [\d.]+ mm/s, between ([\d.]+) and ([\d.]+) mm/s", (tmp_path / "caption.txt").read_text()
    )
    assert caption is not None
    assert float(caption[1]) < 25.0 < float(caption[2])  # as commanded
    made = ["figure.pdf", "figure.png", "both.png", "figures/run-summary.pdf", "run.csv", "run.tiff"]
    assert [name for name in made if not (tmp_path / name).is_file()] == []


def test_lines_that_are_left_out_may_be_any_and_all_others_not() -> None:
    assert agrees(("a", "...", "d"), ["a", "b", "c", "d"])
    assert agrees(("a  1", "...", "d"), ["a 1", "d"])
    assert not agrees(("a", "...", "e"), ["a", "b", "d"])
    assert not agrees(("a",), ["a", "b"])
    assert agrees(("of 2026-01-02",), ["of 2027-11-12"])
