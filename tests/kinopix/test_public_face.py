"""``import kinopix`` from outside: its names, its command, and a lab whose files bear the names of our packages."""

import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

import instrument
import kinopix
from tests.kinopix.fresh import run

OWN_WORDS = ("protocols", "drivers", "instrument")


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    """A folder that holds modules of a lab under names that Kinopix uses too."""
    for name in OWN_WORDS:
        (tmp_path / f"{name}.py").write_text("OF_THE_LAB = True\n")
    return tmp_path


@pytest.mark.parametrize("name", instrument.__all__)
def test_every_public_name_is_given(name: str) -> None:
    assert getattr(kinopix, name) is getattr(instrument, name)


def test_the_names_are_listed() -> None:
    assert set(kinopix.__all__) == set(instrument.__all__)
    assert dir(kinopix) == sorted(instrument.__all__)


def test_a_name_that_is_not_public_is_refused() -> None:
    with pytest.raises(AttributeError, match="module 'kinopix' has no attribute 'nonsense'"):
        _ = getattr(kinopix, "nonsense")  # noqa: B009 - a type checker refuses the plain attribute
    with pytest.raises(ImportError, match="cannot import name 'nonsense'"):
        exec("from kinopix import nonsense", {})  # noqa: S102 - as above


def test_the_command_states_the_version(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "kinopix", "--version"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == f"kinopix {version('kinopix')}"


def test_modules_of_the_lab_beside_its_script_do_not_hide_the_packages(lab: Path) -> None:
    done = run(
        lab, "import kinopix\nprint(kinopix.Plan(frames=3).frames)\nimport protocols\nprint(protocols.__file__)\n"
    )
    assert done.returncode == 0, done.stderr
    frames, origin = done.stdout.splitlines()
    assert frames == "3"
    assert Path(origin) == Path(instrument.__path__[0]).parent / "protocols" / "__init__.py"


def test_the_command_works_in_such_a_folder_too(lab: Path) -> None:
    done = run(
        lab, "import runpy, sys\nsys.argv = ['kinopix', 'drivers']\nrunpy.run_module('kinopix', run_name='__main__')\n"
    )
    assert done.returncode == 0, done.stderr
    assert "dlp7000" in done.stdout


@pytest.mark.parametrize("name", OWN_WORDS)
def test_a_module_of_the_lab_that_was_imported_before_is_named(lab: Path, name: str) -> None:
    done = run(lab, f"import {name}\nassert {name}.OF_THE_LAB\nimport kinopix\n")
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert last == (
        f"ImportError: kinopix: saw a module {name!r} of another origin ({lab.resolve() / name}.py), imported before; "
        f"expected the package {name!r} that Kinopix brings. To do: import kinopix first, or rename your module."
    )
