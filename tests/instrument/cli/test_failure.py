"""What went wrong, in one paragraph and an exit code, whoever raised it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from instrument.cli.failure import exit_code_of
from instrument.cli.options import print_json
from protocols import DeviceDisconnected, InputError


def noted(error: Exception, note: str) -> Exception:
    error.add_note(note)
    return error


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (InputError(saw="a", expected="b", remedy="c"), 2, "kinopix: saw a; expected b. To do: c."),
        (
            DeviceDisconnected(saw="a", expected="b", remedy="c", device="dmd"),
            3,
            "kinopix: dmd: saw a; expected b. To do: c.",
        ),
        (
            OSError(28, "No space left on device"),
            3,
            "saw the operating system refuse: [Errno 28] No space left on device",
        ),
        (PermissionError(13, "Permission denied", "run.h5"), 3, "[Errno 13] Permission denied: 'run.h5'"),
        (
            MemoryError("Unable to allocate 80 GiB"),
            2,
            "more memory asked for than this machine has (Unable to allocate 80 GiB)",
        ),
        (noted(OSError("gone"), "24 of 240 patterns are kept in run.h5"), 3, "24 of 240 patterns are kept in run.h5"),
        (noted(MemoryError("full"), "nothing was recorded"), 2, "nothing was recorded"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, Exception) else "",
)
def test_each_error_with_a_cause_is_a_sentence_and_a_code(
    error: Exception, code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_code_of(error) == code
    printed = capsys.readouterr()
    assert said in printed.err
    assert printed.out == ""


def test_it_is_told_once(tmp_path: Path) -> None:
    """In a program of its own, where nobody else has set up logging: Python then prints by itself what is logged to nobody."""
    program = [sys.executable, "-m", "kinopix", "info", str(tmp_path / "none.h5")]
    ended = subprocess.run(program, cwd=Path(__file__).parents[3], capture_output=True, text=True, check=False)
    assert ended.returncode == 2
    assert ended.stderr.count("no such file") == 1


@pytest.mark.parametrize("mistake", [ZeroDivisionError("x"), KeyError("x"), AssertionError("x")])
def test_a_mistake_of_ours_is_not_dressed_up(mistake: Exception, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code_of(mistake) is None
    assert capsys.readouterr().err == ""


def test_json_on_standard_output_has_null_for_what_is_not_finite(capsys: pytest.CaptureFixture[str]) -> None:
    print_json({"psnr_db": float("inf"), "frames": 8, "rows": [float("nan"), 0.5]}, with_warnings=False)
    assert json.loads(capsys.readouterr().out, parse_constant=pytest.fail) == {
        "psnr_db": None,
        "frames": 8,
        "rows": [None, 0.5],
    }
