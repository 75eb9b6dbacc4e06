"""Machine code that was kept on disk and is broken, or cannot be kept, costs time and nothing else.

Each case is a process of its own with two small loops. The module is loaded by its file, so that no other loop is compiled anew.
"""

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="limits and folders of POSIX")

_MODULE = Path(__file__).parents[2] / "instrument" / "numerics" / "compiled.py"
_LOOPS = """
import importlib.util
import sys

spec = importlib.util.spec_from_file_location("compiled", sys.argv[1])
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
compiled = module.compiled

@compiled("f8(f8)")
def twice(value):
    return 2 * value

@compiled("f8(f8)")
def thrice(value):
    return 3 * value

print(twice(2.0), thrice(2.0))
"""


def compiled_with(folder: Path, cache: Path, *, largest_file: int | None = None) -> str:
    """Compile two loops in a fresh process that keeps code in ``cache``, and give all that it said."""
    script = folder / "loops.py"
    if not script.exists():
        script.write_text(_LOOPS)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache), "PYTHONDONTWRITEBYTECODE": "1"}

    def limit() -> None:
        if largest_file is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, largest_file))

    done = subprocess.run(
        [sys.executable, str(script), str(_MODULE)],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        env=environment,
        preexec_fn=limit,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == "4.0 6.0\n"
    said: str = done.stderr
    return said


@pytest.mark.parametrize(
    ("ending", "garbage"),
    [
        ("nbi", b""),
        ("nbc", b"\x80\x05garbage"),
        pytest.param("nbc", b"", marks=pytest.mark.thorough),
        pytest.param("nbi", b"\x80\x05garbage", marks=pytest.mark.thorough),
    ],
)
def test_broken_code_is_compiled_anew_and_told_once(tmp_path: Path, ending: str, garbage: bytes) -> None:
    cache = tmp_path / "cache"
    assert compiled_with(tmp_path, cache) == ""
    kept = list(cache.rglob(f"*.{ending}"))
    assert len(kept) == 2
    for file in kept:
        file.write_bytes(garbage)
    said = compiled_with(tmp_path, cache)
    assert said.count("RuntimeWarning: kept machine code cannot be used") == 1


def test_a_folder_that_cannot_be_made_is_told_at_most_once(tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("a file where the folder should be")
    assert compiled_with(tmp_path, tmp_path / "cache").count("Warning") <= 1


def test_a_full_disk_keeps_no_code_and_is_told_once(tmp_path: Path) -> None:
    said = compiled_with(tmp_path, tmp_path / "cache", largest_file=100)
    assert said.count("RuntimeWarning: kept machine code cannot be used (OSError") == 1
