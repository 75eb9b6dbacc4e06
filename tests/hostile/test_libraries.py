"""``kinopix check`` says which native code a bench.toml has run, before it is run."""

from pathlib import Path

import pytest

from instrument.cli.main import status
from tests.support.benches import bench_toml, plan_toml


def test_check_names_the_library_of_a_bench(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench = bench_toml(tmp_path)
    library = 'driver = "dlp7000"\nlibrary = "strange[/b].so"\n'
    bench.write_text(bench.read_text().replace('driver = "simulated"\n', library, 1))
    code = status(["check", "--bench", str(bench), "--plan", str(plan_toml(tmp_path))])
    said = " ".join(capsys.readouterr().err.split())
    assert code == 3  # there is no such library
    assert said.startswith("[modulator] library = 'strange[/b].so': native code, which ")


def test_a_bench_without_libraries_is_not_warned_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert status(["check", "--bench", str(bench_toml(tmp_path)), "--plan", str(plan_toml(tmp_path))]) == 0
    assert "native" not in capsys.readouterr().err
