"""``kinopix new-driver``: what it writes is a driver of Kinopix as it stands."""

import importlib
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from instrument.cli.main import status
from instrument.plan import Plan
from protocols import BenchContext, DriverPlugin, DriverUnavailable, LinearStage, TransportPlugin

ROOT = Path(__file__).parents[3]
KINDS = ("stage", "counter", "modulator")


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a package of each kind."""
    folder = tmp_path_factory.mktemp("new")
    for kind in KINDS:
        assert status(["new-driver", f"lab-{kind}", "--kind", kind, "--out", str(folder / f"lab-{kind}")]) == 0
    return folder


def test_a_new_driver_of_each_kind_passes_its_own_tests(packages: Path) -> None:
    """In a process of their own, as an author would: some 120 tests, one of which wants edge times."""
    folders = [packages / f"lab-{kind}" for kind in KINDS]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--import-mode=importlib", *map(str, folders)],
        cwd=packages,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([*map(str, folders), str(ROOT)]), "COLUMNS": "120"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    last = done.stdout.splitlines()[-1]
    assert int(last.split()[0]) > 110, last
    assert "1 skipped" in last


@pytest.mark.parametrize("kind", KINDS)
def test_its_entry_points_lead_to_plugins_and_its_settings_to_a_bench(
    packages: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = packages / f"lab-{kind}"
    monkeypatch.setattr(sys, "path", [str(folder), *sys.path])
    project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
    assert project["name"] == f"lab-{kind}"
    found: dict[str, Any] = {}
    for group, entries in project["entry-points"].items():
        for name, place in entries.items():
            module, attribute = place.split(":")
            found[f"{group} {name}"] = getattr(importlib.import_module(module), attribute)
    driver: Any = found[f"kinopix.{kind}s lab-{kind}"]
    transport: Any = found[f"kinopix.transports lab-{kind}-emulator"]
    assert (type(driver), type(transport)) == (DriverPlugin, TransportPlugin)
    bench = tomllib.loads((folder / "bench.toml").read_text())
    assert bench[kind] == {"driver": f"lab-{kind}", "transport": f"lab-{kind}-emulator"}
    assert {bench[other]["driver"] for other in KINDS if other != kind} == {"simulated"}
    assert Plan.from_toml(folder / "plan.toml").frames == 200
    with pytest.raises(DriverUnavailable, match="no port '/dev/none'"):
        driver.open(driver.settings.model_validate({"port": "/dev/none"}), BenchContext())
    if kind == "stage":
        context = BenchContext()
        spoken = BenchContext(transport=transport.open(transport.settings(), context))
        with driver.open(driver.settings(), spoken) as stage:
            assert isinstance(stage, LinearStage)
            assert stage.position().reported_mm == 50


@pytest.mark.parametrize(
    "name", ["Acme", "acme_m1", "1m", "../m1", "m1-", "", "a" * 61, "json", "class", "protocols", "tests"]
)
def test_a_name_that_is_no_package_or_hides_one_is_refused(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert status(["new-driver", "--kind", "stage", "--", name]) == 2
    assert list(tmp_path.iterdir()) == []


def test_a_folder_with_something_in_it_is_left_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert status(["new-driver", "m1", "--kind", "stage", "--out", str(tmp_path)]) == 2
    assert "which exists" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]
