"""What the timing of the tutorial types is what the page says, and no more than five commands."""

from pathlib import Path

import pytest

from benchmarks.tutorial import PAGE, commands_of, follow


def test_the_page_has_five_commands_between_which_two_files_and_a_picture_are_made() -> None:
    steps = commands_of(PAGE.read_text(encoding="utf-8"))
    typed = [text for kind, text in steps if kind == "type"]
    assert typed == [
        "git clone <this repository> kinopix",
        "cd kinopix && make demo",
        "source .venv/bin/activate",
        "kinopix run --bench own/bench.toml --plan own/plan.toml --out own/run.h5",
        "kinopix analyse own/run.h5",
    ]
    assert [kind for kind, _ in steps] == ["type", "type", "type", "draw", "write", "write", "type", "type"]


def test_commands_go_into_one_shell_and_files_into_the_clone(tmp_path: Path) -> None:
    page = (
        "```sh\nmkdir kinopix\ncd kinopix\n```\n"
        "```toml\n# own/a.toml\nb = 1\n```\n"
        "```console\n$ cp own/a.toml c.toml\nsaid\n```\n"
    )
    times = follow(page, tmp_path)
    assert [command for command, _ in times] == ["mkdir kinopix", "cd kinopix", "cp own/a.toml c.toml"]
    assert (tmp_path / "kinopix" / "c.toml").read_text() == "# own/a.toml\nb = 1\n"


def test_a_command_that_fails_ends_it(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match=r"\$ false"):
        follow("```sh\nfalse\ntrue\n```\n", tmp_path)
