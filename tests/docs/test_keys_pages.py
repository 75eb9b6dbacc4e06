"""The pages of all keys are what the command prints."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from instrument.cli.main import app

REFERENCE = Path(__file__).parents[2] / "docs" / "reference"


@pytest.mark.parametrize("name", ["bench", "plan"])
def test_a_page_is_what_the_command_prints(name: str) -> None:
    """Where this fails, keys have changed: ``kinopix schema bench --markdown > docs/reference/bench.md``, and plan likewise."""
    printed = CliRunner().invoke(app, ["schema", name, "--markdown"])
    assert printed.exit_code == 0
    assert printed.stdout == (REFERENCE / f"{name}.md").read_text(encoding="utf-8")
