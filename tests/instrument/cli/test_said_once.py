"""What a command says stands once on standard error, as a user's shell has it: where nothing logs, nothing is repeated."""

import subprocess
import sys
from pathlib import Path


def test_an_error_is_told_once(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "kinopix", "info", str(tmp_path / "none.h5")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.count("no such file") == 1
