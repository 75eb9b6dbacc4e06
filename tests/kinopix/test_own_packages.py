"""Kinopix's packages are its own, whatever lies beside a script or was imported before."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import instrument
import kinopix
from kinopix.own_packages import PACKAGES, claim_packages

HOME = Path(str(kinopix.__file__)).parents[1]


def python(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a script beside whatever lies in ``folder``, which Python searches first."""
    script = folder / "script.py"
    script.write_text(f"import sys\nsys.path.insert(1, {str(HOME)!r})\n{code}\n")
    bare = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, cwd=folder, env=bare, check=False
    )


@pytest.mark.parametrize("name", PACKAGES)
def test_a_file_of_the_same_name_beside_the_script_is_not_taken_for_ours(name: str, tmp_path: Path) -> None:
    (tmp_path / f"{name}.py").write_text("raise RuntimeError('the lab has its own')\n")
    ran = python(f"import kinopix, {name}\nprint({name}.__file__)", tmp_path)
    assert ran.stderr == ""
    assert Path(ran.stdout.strip()) == HOME / name / "__init__.py"


def test_a_module_of_the_same_name_that_was_imported_before_is_named(tmp_path: Path) -> None:
    (tmp_path / "drivers.py").write_text("")
    ran = python("import drivers\nimport kinopix", tmp_path)
    assert ran.returncode == 1
    assert f"saw a module 'drivers' of another origin ({tmp_path / 'drivers.py'}), imported before" in ran.stderr
    assert "import kinopix first, or rename your module" in ran.stderr


def test_a_folder_without_a_file_of_its_own_is_not_ours_either(tmp_path: Path) -> None:
    (tmp_path / "instrument").mkdir()
    code = "sys.path.remove({0!r})\nimport instrument\nsys.path.insert(1, {0!r})\nimport kinopix".format(str(HOME))
    ran = python(code, tmp_path)
    assert "saw a module 'instrument' of another origin (None)" in ran.stderr


def test_other_modules_of_the_lab_are_found_as_ever(tmp_path: Path) -> None:
    (tmp_path / "alignment.py").write_text("NAME = 'ours'\n")
    (tmp_path / "kit").mkdir()
    (tmp_path / "kit" / "drivers.py").write_text("NAME = 'of the kit'\n")
    ran = python("import kinopix, alignment, kit.drivers\nprint(alignment.NAME, kit.drivers.NAME)", tmp_path)
    assert ran.stdout == "ours of the kit\n"


def test_claiming_twice_adds_one_finder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "meta_path", list(sys.meta_path))
    claim_packages()
    once = list(sys.meta_path)
    claim_packages()
    assert sys.meta_path == once
    assert sys.meta_path[0].__module__ == "kinopix.own_packages"


def test_python_m_kinopix_is_the_command(tmp_path: Path) -> None:
    """Also where a lab's folder has an ``instrument.py``."""
    (tmp_path / "instrument.py").write_text("raise RuntimeError('the lab has its own')\n")
    ran = python(
        "import runpy\nsys.argv = ['kinopix', '--version']\nrunpy.run_module('kinopix', run_name='__main__')", tmp_path
    )
    assert (ran.returncode, ran.stderr) == (0, "")
    assert ran.stdout.startswith("kinopix 0.")


def test_importing_the_command_s_module_runs_nothing() -> None:
    ran = subprocess.run(
        [sys.executable, "-c", "import kinopix.__main__"], capture_output=True, text=True, cwd=HOME, check=True
    )
    assert (ran.stdout, ran.stderr) == ("", "")


def test_the_public_names_are_those_of_the_framework() -> None:
    assert dir(kinopix) == sorted(dir(instrument))
    assert {"Instrument", "Plan", "analyse", "track"} <= set(dir(kinopix))
    assert kinopix.Plan is instrument.Plan
    with pytest.raises(AttributeError, match="module 'kinopix' has no attribute 'holography'"):
        getattr(kinopix, "holography")  # noqa: B009 - a plain attribute would be refused by the type checkers


def test_what_lies_beside_our_packages_is_not_claimed(tmp_path: Path) -> None:
    """A lab's own ``examples.py`` stays the lab's, though the repository has a folder of that name."""
    (tmp_path / "examples.py").write_text("NAME = 'ours'\n")
    assert python("import kinopix, examples\nprint(examples.NAME)", tmp_path).stdout == "ours\n"
