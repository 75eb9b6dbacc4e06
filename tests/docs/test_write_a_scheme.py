"""The scheme of ``docs/how-to/write-a-scheme.md`` is written out of the page, announced, proved and run as the page says."""

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests.support.benches import bench_toml

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "write-a-scheme.md"


def code_blocks() -> dict[str, str]:
    """File name to content, for each block of the page that begins with one."""
    blocks: list[tuple[str, str]] = re.findall(r"```(?:python|toml)\n# (\S+)\n(.*?)```", PAGE.read_text(), re.DOTALL)
    return dict(blocks)


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the page's files, installed as pip would record it."""
    folder = tmp_path_factory.mktemp("tutorial")
    for name, code in code_blocks().items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(code)
    (folder / "four_step" / "__init__.py").touch()
    project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
    record = folder / f"four_step-{project['version']}.dist-info"
    record.mkdir()
    (record / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    (record / "entry_points.txt").write_text(
        "\n".join(
            f"[{group}]\n" + "\n".join(f"{name} = {value}" for name, value in points.items())
            for group, points in project["entry-points"].items()
        )
    )
    return folder


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python there, as the scheme's author would."""
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


COMMANDS = """
import contextlib, io, json, sys
from instrument.cli.main import status

printed = []
for command in json.loads(sys.argv[1]):
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        if code := status(command):
            sys.exit(f"{command}: {code}")
    printed.append(out.getvalue())
print(json.dumps(printed))
"""


def kinopix(folder: Path, *commands: list[str]) -> list[str]:
    """Run commands there, one after the other in a process that the package is known to, and give what each printed."""
    done = run(folder, "-c", COMMANDS, json.dumps(commands))
    assert done.returncode == 0, done.stdout + done.stderr
    printed: list[str] = json.loads(done.stdout)
    return printed


def test_the_page_has_the_four_files() -> None:
    assert list(code_blocks()) == [
        "four_step/scheme.py",
        "pyproject.toml",
        "plan.toml",
        "tests/test_four_step.py",
    ]


def test_the_tests_of_the_page_pass(package: Path) -> None:
    done = run(package, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 passed" in done.stdout


def test_the_commands_of_the_page_list_check_run_and_analyse_it(package: Path) -> None:
    bench = ["--bench", str(bench_toml(package)), "--plan", "plan.toml"]
    drivers, checked, _, analysed = kinopix(
        package,
        ["drivers", "--json"],
        ["check", *bench, "--json"],
        ["run", *bench, "--out", "run.h5"],
        ["analyse", "run.h5", "--json"],
    )
    listed = {row["name"]: row for row in json.loads(drivers)["plugins"]}
    assert listed["four-step"]["summary"].startswith("eight patterns")
    assert json.loads(checked)["ok"]
    figures = json.loads(analysed)
    assert figures["frames"] == 400
    assert figures["displacement_mse_px2"] < 0.01
    assert figures["psnr_db"] is None
    assert [Path(picture).name for picture in figures["pictures"]] == [
        f"run-{name}.png" for name in ("summary", "trajectory", "error", "timing")
    ]
