"""The day at the paper's bench, in its small form."""

import re
import runpy
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "examples" / "experiment_day.py"


@pytest.mark.thorough
def test_the_whole_day_is_recorded_and_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", [str(SCRIPT), str(tmp_path), "--short"])
    runpy.run_path(str(SCRIPT), run_name="__main__")
    said = capsys.readouterr().out.splitlines()

    assert said[0] == "static reference: 1250 patterns at 100 a second, 61.04 % sampling"
    assert float(re.findall(r"([\d.]+) dB", said[1])[0]) > 20
    scale = [float(re.findall(r"([\d.]+) px/mm", line)[0]) for line in said[2:4]]
    assert scale == pytest.approx([1.8, 1.8], rel=0.12)  # the bench's own is 7.2 px/mm in 128 px
    subtracted = [line for line in said[4:] if "from the run alone" not in line]
    assert [line.split(":")[0].split(",")[0] for line in subtracted] == [
        "25 mm/s",
        "from rest",
        "R = 8.60",
        "R = 3.25",
        "R = 1.60",
        "R = 1.04",
    ]
    errors = [float(re.findall(r"error ([\d.]+) px", line)[0]) for line in subtracted]
    assert max(errors) < 0.3
    assert len(list(tmp_path.glob("background-*.h5"))) == len(list(tmp_path.glob("with-background-*.h5"))) == 4


def test_without_a_folder_the_script_says_how_it_is_called(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", [str(SCRIPT)])
    with pytest.raises(SystemExit, match=r"python examples/experiment_day\.py results/"):
        runpy.run_path(str(SCRIPT), run_name="__main__")
