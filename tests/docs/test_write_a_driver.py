"""The driver of ``docs/how-to/write-a-driver.md`` is written out of the page, announced, and put through the suite."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from instrument.storage import open_recording

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "write-a-driver.md"


def code_blocks(language: str = "python") -> dict[str, str]:
    """File name to code, for each block of the page that begins with its file's name."""
    blocks: list[tuple[str, str]] = re.findall(rf"```{language}\n# (\S+)\n(.*?)```", PAGE.read_text(), re.DOTALL)
    return dict(blocks)


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the page's files."""
    folder = tmp_path_factory.mktemp("tutorial")
    for name, code in (code_blocks() | code_blocks("toml")).items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(code)
    (folder / "acme_stage" / "__init__.py").touch()
    install(folder)
    return folder


def install(folder: Path) -> None:
    """Make of the page's pyproject.toml what ``pip install -e .`` would make of it."""
    announced = tomllib.loads((folder / "pyproject.toml").read_text())
    project = announced["project"]
    info = folder / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    groups = project["entry-points"]
    lines = [
        f"[{group}]\n" + "\n".join(f"{name} = {value}" for name, value in groups[group].items()) for group in groups
    ]
    (info / "entry_points.txt").write_text("\n".join(lines))
    assert announced["tool"]["setuptools"]["packages"] == ["acme_stage"]
    assert announced["build-system"]["build-backend"] == "setuptools.build_meta"


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run pytest there, as an author of a driver would."""
    return python(folder, "pytest", "-q", "-p", "no:cacheprovider", *arguments)


def python(folder: Path, *module: str) -> subprocess.CompletedProcess[str]:
    """Run a module there."""
    paths = os.pathsep.join([str(folder), str(PAGE.parents[2])])
    return subprocess.run(
        [sys.executable, "-m", *module],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1", "COLUMNS": "120"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_the_page_has_the_four_files() -> None:
    assert list(code_blocks()) == [
        "acme_stage/driver.py",
        "acme_stage/controller.py",
        "acme_stage/conformance.py",
        "tests/test_contract.py",
    ]
    assert len(code_blocks()["acme_stage/driver.py"].splitlines()) < 150


def test_the_driver_of_the_page_conforms(package: Path) -> None:
    options = ["--pyargs", "protocols.conformance", "--kinopix-driver", "acme_stage.conformance:stage_rig"]
    done = run(package, *options)
    assert done.returncode == 0, done.stdout + done.stderr
    passed = re.search(r"(\d+) passed in", done.stdout)
    assert passed, done.stdout
    assert int(passed[1]) > 40
    assert "skipped" not in done.stdout


def test_the_page_s_stage_is_listed_and_carries_the_object_on_a_simulated_bench(package: Path) -> None:
    """25 frames at 10 mm/s: 7.5 ms are 0.075 mm, and 0.54 px at 7.2 px/mm."""
    plan = "frames = 25\nimage_size = 32\nsuperpixel = 4\n[motion]\nvelocity_mm_s = 10.0\nacceleration_mm_s2 = 50.0\n"
    (package / "plan.toml").write_text(plan + "start_mm = 20.0\n")
    done = python(package, "kinopix", "run", "--bench", "bench.toml", "--plan", "plan.toml", "--out", "run.h5")
    assert done.returncode == 0, done.stdout + done.stderr
    recording = open_recording(package / "run.h5")
    assert recording.truth is not None
    travel_px = np.hypot(*recording.truth.displacement_px[-1])
    assert travel_px == pytest.approx(10 * 24 * 6 * 50e-6 * 7.2 * 32 / 128, rel=0.05)


def test_the_suite_may_be_imported_instead(package: Path) -> None:
    done = run(package, "tests", "-k", "signed or any_order")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 passed" in done.stdout, done.stdout


def test_without_a_driver_the_suite_says_what_to_add(package: Path) -> None:
    done = run(package, "--pyargs", "protocols.conformance")
    assert done.returncode == pytest.ExitCode.USAGE_ERROR
    assert "To do: add --kinopix-driver my_package.conformance:stage_rig" in done.stderr
    assert "Traceback" not in done.stderr
