"""Every command that a document names is there with its options, and those that stand in a block are run."""

import re
import shlex
import shutil
from pathlib import Path
from typing import Any, Final

import pytest
import typer

from instrument.cli.main import app, status
from instrument.plan import Plan
from tests.docs.pages import PAGES, ROOT, command_lines, inline_code, text_of
from tests.support.benches import SMALL, bench_toml, plan_toml

_PROSE: Final = re.compile(r"\.{3}|[<>].*|\b[A-Z]{3,}\b")

ELSEWHERE: Final = {
    "serve": "tests/instrument/cli/test_serve.py",
    "--web": "tests/instrument/cli/test_serve.py",
    "--scheduler": "tests/instrument/series/test_cluster.py",
    "--span-mm": "tests/instrument/cli/test_calibrate_displacement.py",
    "--from": "tests/instrument/cli/test_calibrate_displacement.py",
    "--format": "tests/docs/test_tutorials.py",
    "convert": "tests/instrument",
    "demo": "tests/instrument/cli/test_commands.py",
}
"""Words of commands that run in tests of their own."""

AGAIN: Final = {"kinopix analyse run.h5", "kinopix compare still.h5 run.h5 --picture both.png"}
"""Commands that the tutorials run too."""

TUTORIALS: Final = "docs/tutorials/"
"""They are run word by word by ``test_tutorials.py``."""


def _known(words: list[str]) -> tuple[str, set[str]]:
    """Give the name of a command, and the options that it has."""
    group: Any = typer.main.get_command(app)
    options: set[str] = {option for each in group.params for option in each.opts}
    name: list[str] = []
    for word in words:
        if word in getattr(group, "commands", {}):
            group = group.commands[word]
            name.append(word)
            options |= {option for each in group.params for option in each.opts}
    return " ".join(name), options


@pytest.mark.parametrize("page", PAGES)
def test_every_command_that_a_page_names_is_there_with_its_options(page: str) -> None:
    lines = command_lines(page, "kinopix") + [code for code in inline_code(page) if code.startswith("kinopix ")]
    for line in lines:
        words = shlex.split(_PROSE.sub("", line).removesuffix("\\"))[1:]
        name, options = _known(words)
        told = [word.split("=")[0] for word in words if word.startswith("--")]
        assert name or told, f"{line}: no such command"
        assert [option for option in told if option not in {*options, "--help"}] == [], line


def test_the_page_of_commands_has_them_all() -> None:
    group: Any = typer.main.get_command(app)
    page = text_of("docs/reference/commands.md")
    assert [name for name in group.commands if not re.search(rf"\bkinopix {name}\b", page)] == []


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with everything that the pages take for granted: a bench, a plan, recordings, a folder of recordings."""
    folder = tmp_path_factory.mktemp("lab")
    bench_toml(folder, 'noise = { kind = "poisson", peak_counts = 400, seed = 1 }\nfresh_noise = true')
    plan_toml(folder, SMALL.model_copy(update={"frames": 120}))
    _run(folder, "run --bench bench.toml --plan plan.toml --out run.h5")
    still = SMALL.model_copy(
        update={
            "frames": 200,
            "motion": None,
            "scheme": Plan.model_validate({"frames": 1, "scheme": "hadamard"}).scheme,
        }
    )
    (folder / "still").mkdir()
    plan_toml(folder / "still", still)
    _run(folder, "run --bench bench.toml --plan still/plan.toml --out still.h5")
    _run(folder, "analyse run.h5 --no-pictures")
    for name in ("analysed.h5", "a.h5", "b.h5", "long.h5", "runs/1.h5", "series/1.h5", "series/2.h5"):
        (folder / name).parent.mkdir(exist_ok=True)
        shutil.copy(folder / "run.h5", folder / name)
    return folder


def _to_run() -> list[str]:
    """Give each whole command that no other test runs, once."""
    pages = [page for page in PAGES if not page.startswith(TUTORIALS)]
    lines = [" ".join(line.split()) for page in pages for line in command_lines(page, "kinopix")]
    return [
        line for line in dict.fromkeys(lines) if not line.endswith("...") and not {*line.split()} & ELSEWHERE.keys()
    ]


def _run(folder: Path, command: str) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert status(shlex.split(command)) == 0, command


def test_every_test_that_runs_a_command_elsewhere_is_there() -> None:
    assert [path for path in ELSEWHERE.values() if not (ROOT / path).exists()] == []


@pytest.mark.parametrize(
    "command",
    [pytest.param(line, marks=pytest.mark.thorough if line in AGAIN else ()) for line in _to_run()],
)
def test_the_commands_of_the_pages_run(lab: Path, command: str) -> None:
    """As they stand there, in a folder in which they may stand; several recordings are analysed here, not by new processes."""
    shutil.copy(lab / "analysed.h5", lab / "run.h5")
    several = " --workers 1" if "series/" in command or "runs/" in command else ""
    _run(lab, command.removeprefix("kinopix ") + several + (" --overwrite" if " --out " in command else ""))
