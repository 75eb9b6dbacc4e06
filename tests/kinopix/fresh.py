"""Python in a fresh process, as a lab's script runs."""

import subprocess
import sys
from pathlib import Path

HEAVY = ("h5py", "matplotlib", "numba", "numpy", "pydantic", "scipy")
"""Libraries that take long to import."""

_RUN_THE_COMMAND = """
import runpy, sys
sys.argv = {arguments!r}
try:
    runpy.run_module("kinopix", run_name="__main__", alter_sys=True)
except SystemExit as end:
    print("exit code", end.code)
"""

_SHOW_HEAVY = f"""
import sys
print(*sorted(set({HEAVY!r}) & set(sys.modules)))
"""


def run(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    """Run a script that lies in ``folder``, with that folder as the current one."""
    script = folder / "a_script_of_the_lab.py"
    script.write_text(code)
    return subprocess.run(
        [sys.executable, script.name], cwd=folder, capture_output=True, text=True, check=False, timeout=120
    )


def loaded_by(folder: Path, code: str) -> set[str]:
    """Give those of ``HEAVY`` that a script has loaded when it is through."""
    done = run(folder, code + _SHOW_HEAVY)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.splitlines()[-1].split())


def loaded_by_command(folder: Path, *arguments: str) -> set[str]:
    """Give those of ``HEAVY`` that ``python -m kinopix`` has loaded when it ends, which it must with 0."""
    code = _RUN_THE_COMMAND.format(arguments=["kinopix", *arguments]) + _SHOW_HEAVY
    done = run(folder, code)
    assert done.returncode == 0, done.stderr
    *_, end, heavy = done.stdout.splitlines()
    assert end == "exit code 0", done.stdout + done.stderr
    return set(heavy.split())
