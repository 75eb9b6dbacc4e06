"""``kinopix recover`` and ``kinopix check FILE``: what they say and how they end."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from instrument.cli.main import status
from instrument.plan import Plan
from instrument.storage import RecordingWriter, layout
from instrument.storage.spill import Record, write_spill
from protocols import CountBlock


@pytest.fixture
def left(tmp_path: Path) -> Path:
    """A recording of 30 of 60 patterns that was not closed, and the other 30 in a spill file."""
    values = np.arange(60.0)
    made = RecordingWriter(tmp_path / "made.h5", Plan(frames=10, image_size=8), picture_time_s=50e-6)
    made.append_raw(CountBlock(0, values[:30]))
    made.append(values[:30])
    shutil.copy(tmp_path / "made.h5", tmp_path / "run.h5")
    records = [
        Record(name, 30, values[30:] if name in {layout.VALUES, layout.RAW_COUNTS} else np.full(30, np.nan))
        for name in (layout.VALUES, layout.EDGE_TIME_S, layout.RAW_COUNTS, layout.RAW_EDGE_TIME_S)
    ]
    write_spill(tmp_path / "run.h5.1.spill", made.run, records)
    made.close()
    return tmp_path / "run.h5"


def test_check_and_recover_say_what_there_is(left: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert status(["check", str(left), "--json"]) == 3
    report = json.loads(capsys.readouterr().out)
    rows = {row["name"]: row["message"] for row in report["checks"]}
    assert rows["completeness"].startswith("5 of 10 frames; cut off")
    assert not report["ok"]

    assert status(["recover", str(left), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "recording": str(left),
        "recovered": True,
        "patterns": 60,
        "joined": 30,
        "spills": [str(left.with_name("run.h5.1.spill"))],
        "warnings": [],
    }
    assert status(["recover", str(left)]) == 0
    assert "there is nothing to do" in " ".join(capsys.readouterr().out.split())
    assert status(["check", str(left)]) == 3  # sound, and cut off all the same


def test_a_spill_file_that_is_cut_is_told(left: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spill = left.with_name("run.h5.1.spill")
    spill.write_bytes(spill.read_bytes()[:-1])
    assert status(["recover", str(left), "--out", str(left.with_name("whole.h5"))]) == 0
    said = " ".join(capsys.readouterr().err.split())
    assert "bytes at the end of the spill file are no whole record, and are left out" in said


def test_as_json_what_is_lost_is_among_the_warnings(left: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spill = left.with_name("run.h5.1.spill")
    spill.write_bytes(spill.read_bytes()[:-1])
    assert status(["recover", str(left), "--json"]) == 0
    (warning,) = json.loads(capsys.readouterr().out)["warnings"]
    assert "are no whole record, and are left out" in warning


@pytest.mark.parametrize(
    ("arguments", "saw"),
    [
        ([], "nothing to check"),
        (["run.h5", "--bench", "b.toml"], "a recording and --bench"),
        (["run.h5", "--bench", "b.toml", "--plan", "p.toml"], "a recording and --bench and --plan"),
        (["--plan", "p.toml"], "saw --plan"),
    ],
)
def test_check_takes_a_recording_or_a_plan_on_a_bench(
    arguments: list[str], saw: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status(["check", *arguments]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert saw in said
    assert "kinopix check run.h5, or kinopix check --bench" in said
