"""The program of the how-to on the page in the browser runs."""

from pathlib import Path

import pytest

from instrument.storage import open_recording
from tests.docs.pages import blocks
from tests.support.benches import bench_toml, plan_toml

PAGE = "docs/how-to/page.md"


def test_the_program_of_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    bench_toml(tmp_path, 'object = "letter-B"')
    plan_toml(tmp_path)
    (program,) = blocks(PAGE, "python")
    exec(compile(program, PAGE, "exec"), {})  # noqa: S102 - our own
    assert capsys.readouterr().out.startswith("http://127.0.0.1:")
    assert len(open_recording(tmp_path / "run.h5")) == 40
