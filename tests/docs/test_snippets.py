"""What a document shows can be copied: its Python runs, its tables load, and the programs and files that it names are there."""

import re
import shutil
import tomllib
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

from instrument.config import load_bench
from instrument.series import Request, analyse_series, recordings_in, write_table
from instrument.session import Instrument, RunAborted
from protocols import SafeStateFailed
from tests.docs.pages import PAGES, ROOT, blocks, command_lines, inline_code, text_of
from tests.support.benches import SMALL, bench_toml, plan_toml

FEWER: Final = {
    "(16_384, 32_768)": "(20, 60)",
    "window_frames=50_000": "window_frames=60",
    "processes=4": "processes=1",
}
"""What is said smaller here than on the pages."""

DEVICES: Final = ("dlp7000", "dlpc900", "grbl", "h10682", "ka400z", "ni-analog", "serial-counter", "zaber")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with bench, plan and recordings."""
    folder = tmp_path_factory.mktemp("recorded")
    bench = bench_toml(folder, 'noise = { kind = "poisson", peak_counts = 400, seed = 1 }')
    plan_toml(folder)
    with Instrument.from_toml(bench) as opened:
        opened.run(SMALL.model_copy(update={"frames": 120}), folder / "run.h5")
    shutil.copy(folder / "run.h5", folder / "long.h5")
    (folder / "series").mkdir()
    shutil.copy(folder / "run.h5", folder / "series" / "1.h5")
    write_table(analyse_series(recordings_in([folder / "series"]), Request()), folder / "series.parquet")
    return folder


@pytest.mark.parametrize(
    "page", ["README.md", *(f"docs/how-to/{name}.md" for name in ("live", "long-recordings", "many-runs"))]
)
def test_the_programs_of_a_page_run(recorded: Path, monkeypatch: pytest.MonkeyPatch, page: str) -> None:
    """Those of other pages have tests of their own."""
    monkeypatch.chdir(recorded)
    monkeypatch.setattr(mpl, "get_backend", lambda: "agg")
    programs = blocks(page, "python")
    assert programs
    for program in programs:
        (recorded / "run.h5").unlink(missing_ok=True)
        for large, small in FEWER.items():
            program = program.replace(large, small)  # noqa: PLW2901
        exec(compile(program, page, "exec"), {"__name__": "__main__"})  # noqa: S102 - our own page
    plt.close("all")


def test_what_stops_a_run_stops_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (program,) = blocks("docs/how-to/stop.md", "python")
    with Instrument.from_toml(bench_toml(tmp_path, "realtime = true")) as bench:
        names = {"bench": bench, "plan": SMALL, "RunAborted": RunAborted, "SafeStateFailed": SafeStateFailed}
        exec(compile(program, "stop.md", "exec"), names)  # noqa: S102 - our own page
    assert "recorded" in capsys.readouterr().out, "what is kept is told"


def test_a_recording_is_read_with_h5py_alone(
    recorded: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(recorded)
    shutil.copy("long.h5", "run.h5")
    (program,) = blocks("docs/reference/recording.md", "python")
    names: dict[str, Any] = {}
    exec(compile(program, "recording.md", "exec"), names)  # noqa: S102 - our own page
    assert names["values"].shape == (120, 6)
    assert '"frames":120' in capsys.readouterr().out.replace(" ", "")


@pytest.mark.parametrize("name", DEVICES)
def test_the_tables_of_a_device_load(tmp_path: Path, name: str) -> None:
    tables = blocks(f"docs/how-to/{name}.md", "toml")
    assert tables
    for text in tables:
        (tmp_path / "bench.toml").write_text(text)
        (role,) = tomllib.loads(text)
        assert load_bench(tmp_path / "bench.toml", needed=[role]).devices[role] is not None


def test_the_tables_of_the_light_and_of_a_calibration_load(tmp_path: Path) -> None:
    tables = [*blocks("docs/explanation/light.md", "toml"), "[light]\n"]
    assert len(tables) == 3
    for text in tables:
        bench = bench_toml(tmp_path)
        bench.write_text(bench.read_text() + text)
        load_bench(bench)
    (named,) = blocks("docs/how-to/displacement.md", "toml")
    assert tomllib.loads(named) == {"calibration": "calibration.toml"}


def test_the_entry_point_of_a_driver_is_in_the_group_that_is_looked_in() -> None:
    (text,) = blocks("CONTRIBUTING.md", "toml")
    ours = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]
    assert tomllib.loads(text)["project"]["entry-points"].keys() <= ours.keys()


def test_every_target_of_make_that_a_page_names_is_there() -> None:
    targets = set(re.findall(r"^([a-z][a-z -]*):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    known = {name for target in targets for name in target.split()}
    lines = [(page, line) for page in PAGES for line in command_lines(page, "make") + inline_code(page)]
    named = [(page, line.split()[1]) for page, line in lines if re.fullmatch(r"make [a-z-]+", line)]
    assert len(named) > 6
    assert [(page, name) for page, name in named if name not in known] == []


def test_every_module_and_file_that_a_command_names_is_there() -> None:
    """``python -m benchmarks.x``, ``python path.py`` and ``pytest path``."""
    texts = {page: text_of(page) for page in PAGES}
    modules = {
        (page, name) for page, text in texts.items() for name in re.findall(r"python -m (benchmarks\.\w+)", text)
    }
    files = {
        (page, name)
        for page, text in texts.items()
        for name in re.findall(r"(?:python|pytest) ((?:tests|docs|examples|benchmarks)/[\w/.-]*\w)", text)
    }
    assert len(modules) > 20
    assert len(files) > 10
    assert [
        pair for pair in sorted(modules) if not (ROOT / pair[1].replace(".", "/")).with_suffix(".py").is_file()
    ] == []
    assert [pair for pair in sorted(files) if not (ROOT / pair[1]).exists()] == []
