"""The driver of ``docs/how-to/write-a-driver.md`` is written out of the page, announced, and put through the suite."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

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
    for name in ("acme_stage", "acme_light"):
        (folder / name / "__init__.py").touch()
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
    assert announced["tool"]["setuptools"]["packages"] == ["acme_stage", "acme_light"]
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


def test_the_page_has_these_files() -> None:
    assert list(code_blocks()) == [
        "acme_stage/driver.py",
        "acme_stage/controller.py",
        "acme_stage/conformance.py",
        "tests/test_contract.py",
        "acme_light/counter.py",
        "acme_light/modulator.py",
        "acme_light/emulators.py",
        "acme_light/conformance.py",
    ]
    assert list(code_blocks("toml")) == ["pyproject.toml", "bench.toml", "acme.toml"]
    assert len(code_blocks()["acme_stage/driver.py"].splitlines()) < 150


def test_the_drivers_of_the_page_conform(package: Path) -> None:
    options = ["--pyargs", "protocols.conformance", "--kinopix-driver", "acme_stage.conformance:stage_rig"]
    for rig in ("counter_rig", "modulator_rig"):
        options += ["--kinopix-driver", f"acme_light.conformance:{rig}"]
    done = run(package, *options)
    assert done.returncode == 0, done.stdout + done.stderr
    passed = re.search(r"(\d+) passed, 1 skipped in", done.stdout)
    assert passed, done.stdout
    assert int(passed[1]) > 110


RUNS = """
import sys
import numpy as np
from instrument.config import list_plugins
from instrument.plan import MotionPlan, Plan
from instrument.session import Instrument

names = {(line.plugin.kind, line.plugin.name, line.plugin.distribution) for line in list_plugins()}
for kind, name in (("stage", "acme-m1"), ("counter", "acme-c1"), ("modulator", "acme-d1"), ("transport", "acme-m1-emulator")):
    assert (kind, name, "acme-devices") in names, names
plan = Plan(
    frames=25, image_size=32, superpixel=4, motion=MotionPlan(start_mm=20.0, velocity_mm_s=10.0, acceleration_mm_s2=50.0)
)
for bench in ("bench.toml", "acme.toml"):
    with Instrument.from_toml(bench) as opened:
        recording = opened.run(plan, f"{bench}.h5")
    print(bench, recording.timing.verdict, recording.timing.edges_seen, *np.hypot(*recording.truth.displacement_px.T)[[0, -1]])
"""


def test_the_page_s_devices_do_a_run_and_the_stage_carries_the_object(package: Path) -> None:
    """25 frames at 10 mm/s: 24 x 300 us are 72 um, and 0.13 px at 1.8 px/mm. 150 patterns have 151 edges."""
    (package / "runs.py").write_text(RUNS)
    done = python(package, "runs")
    assert done.returncode == 0, done.stdout + done.stderr
    lines = [line.split() for line in done.stdout.splitlines()]
    assert [line[:3] for line in lines] == [["bench.toml", "good", "151"], ["acme.toml", "good", "151"]]
    for line in lines:
        assert [float(px) for px in line[3:]] == pytest.approx([0.0, 10 * 24 * 6 * 50e-6 * 7.2 * 32 / 128], abs=0.01)


@pytest.mark.thorough
def test_the_page_s_stage_is_commissioned_with_its_own_question(package: Path) -> None:
    done = python(
        package, "kinopix", "probe", "--bench", "acme.toml", "--commission", "--only", "stage", "--yes", "--out", "acme"
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1. Is a millimetre a millimetre?\n      [ok] see travel above" in (package / "acme.txt").read_text()


def test_the_suite_may_be_imported_instead(package: Path) -> None:
    done = run(package, "tests", "-k", "signed or any_order")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 passed" in done.stdout, done.stdout


def test_without_a_driver_the_suite_says_what_to_add(package: Path) -> None:
    done = run(package, "--pyargs", "protocols.conformance")
    assert done.returncode == pytest.ExitCode.USAGE_ERROR
    assert "To do: add --kinopix-driver my_package.conformance:stage_rig" in done.stderr
    assert "Traceback" not in done.stderr
