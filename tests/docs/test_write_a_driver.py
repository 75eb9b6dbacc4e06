"""The driver of ``docs/how-to/write-a-driver.md`` is written out of the page, announced, and put through the suite."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "write-a-driver.md"


def code_blocks() -> dict[str, str]:
    """File name to code, for each Python block of the page."""
    blocks: list[tuple[str, str]] = re.findall(r"```python\n# (\S+)\n(.*?)```", PAGE.read_text(), re.DOTALL)
    return dict(blocks)


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the page's files."""
    folder = tmp_path_factory.mktemp("tutorial")
    for name, code in code_blocks().items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(code)
    (folder / "acme_stage" / "__init__.py").touch()
    return folder


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run pytest there, as an author of a driver would."""
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"},
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


def test_the_suite_may_be_imported_instead(package: Path) -> None:
    done = run(package, "tests", "-k", "signed or any_order")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 passed" in done.stdout, done.stdout


def test_without_a_driver_the_suite_says_what_to_add(package: Path) -> None:
    done = run(package, "--pyargs", "protocols.conformance")
    assert done.returncode == pytest.ExitCode.USAGE_ERROR
    assert "To do: add --kinopix-driver my_package.conformance:stage_rig" in done.stderr
    assert "Traceback" not in done.stderr
