"""A command loads what it stands on, and no more: looked at in a fresh process, after the command has done its work."""

import subprocess
import sys
from pathlib import Path

import pytest

from instrument.session import Instrument
from tests.support.benches import SMALL, bench_toml, plan_toml

HEAVY = ("numba", "scipy", "matplotlib")

COMMAND = """
import runpy, sys
sys.argv = ["kinopix", *sys.argv[1:]]
try:
    runpy.run_module("kinopix", run_name="__main__", alter_sys=True)
except SystemExit as end:
    code = end.code or 0
print(code, *sorted({name.split(".")[0] for name in sys.modules}), file=sys.stderr)
"""


def loaded_by(*arguments: str | Path) -> set[str]:
    """Top-level packages that are loaded after a command that ended well."""
    done = subprocess.run(
        [sys.executable, "-c", COMMAND, *map(str, arguments)], check=True, capture_output=True, text=True
    )
    code, *packages = done.stderr.splitlines()[-1].split()
    assert code == "0", done.stderr
    return set(packages)


@pytest.mark.parametrize("arguments", [("--help",), ("run", "--help"), ("info", "--help"), ("--version",)])
def test_a_help_text_loads_no_arrays(arguments: tuple[str, ...]) -> None:
    loaded = loaded_by(*arguments)
    assert "typer" in loaded
    assert loaded.isdisjoint({"numpy", "h5py", *HEAVY})


@pytest.mark.parametrize("command", ["check", "info"])
def test_a_command_that_analyses_nothing_loads_no_solver_and_no_plots(command: str, tmp_path: Path) -> None:
    bench, plan = bench_toml(tmp_path), plan_toml(tmp_path)
    arguments: list[str | Path] = ["--bench", bench, "--plan", plan]
    if command == "info":
        with Instrument.from_toml(bench) as instrument:
            instrument.run(SMALL, tmp_path / "run.h5")
        arguments = [tmp_path / "run.h5"]
    loaded = loaded_by(command, *arguments)
    assert "numpy" in loaded
    assert loaded.isdisjoint(HEAVY)


def test_the_live_view_loads_the_solver_that_it_needs(tmp_path: Path) -> None:
    """The look at the modules sees what is there."""
    bench, plan = bench_toml(tmp_path), plan_toml(tmp_path)
    assert "numba" in loaded_by("run", "--live", "--bench", bench, "--plan", plan, "--out", tmp_path / "run.h5")
