"""The pages on the page in the browser and on the command: their program runs, and their commands have these options."""

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import typer

from instrument.cli.main import app
from instrument.storage import open_recording
from tests.support.benches import bench_toml, plan_toml

DOCS = Path(__file__).parents[2] / "docs"
PAGES = ("how-to/page.md", "reference/commands.md")


def test_the_program_of_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    bench_toml(tmp_path, 'object = "letter-B"')
    plan_toml(tmp_path)
    (program,) = re.findall(r"```python\n(.*?)```", (DOCS / PAGES[0]).read_text(encoding="utf-8"), re.DOTALL)
    exec(compile(program, PAGES[0], "exec"), {})  # noqa: S102 - our own
    assert capsys.readouterr().out.startswith("http://127.0.0.1:")
    assert len(open_recording(tmp_path / "run.h5")) == 40


@pytest.mark.parametrize("page", PAGES)
def test_every_command_is_there_with_its_options(page: str) -> None:
    text = (DOCS / page).read_text(encoding="utf-8")
    lines = [
        line.split("  #")[0] for block in re.findall(r"```\n(.*?)```", text, re.DOTALL) for line in block.splitlines()
    ]
    commands = [shlex.split(line.replace("...", "")) for line in lines if line.startswith("kinopix ")]
    assert len(commands) >= 4
    group: Any = typer.main.get_command(app)
    for words in commands:
        name = next(word for word in words[1:] if word in group.commands)
        known: set[str] = {o for command in (group, group.commands[name]) for each in command.params for o in each.opts}
        assert [word for word in words if word.startswith("--") and word not in known] == []
