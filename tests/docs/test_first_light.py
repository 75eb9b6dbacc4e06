"""The tutorial, as a newcomer types it."""

from pathlib import Path

import pytest

from instrument.config import read_calibration
from tests.docs.transcript import Typed, agrees, prepare, printed_by, typed

PAGE = Path(__file__).parents[2] / "docs" / "tutorials" / "first-light.md"


def test_every_command_of_the_page_prints_what_the_page_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    commands = 0
    for step in typed(PAGE.read_text(encoding="utf-8")):
        if isinstance(step, Typed):
            printed = printed_by(step.command)
            assert agrees(step.shown, printed), f"$ {step.command}\n" + "\n".join(printed)
            commands += 1
        else:
            prepare(*step, tmp_path)
    assert commands > 12
    found = read_calibration(tmp_path / "calibration.toml")
    assert list(found.sections) == ["displacement", "detector", "mirrors", "light", "alignment"]
    assert read_calibration(tmp_path / "emulated-calibration.toml").displacement is not None


def test_lines_that_are_left_out_may_be_any_and_all_others_not() -> None:
    assert agrees(("a", "...", "d"), ["a", "b", "c", "d"])
    assert agrees(("a  1", "...", "d"), ["a 1", "d"])
    assert not agrees(("a", "...", "e"), ["a", "b", "d"])
    assert not agrees(("a",), ["a", "b"])
    assert agrees(("of 2026-01-02",), ["of 2027-11-12"])
