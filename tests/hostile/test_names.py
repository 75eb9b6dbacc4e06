"""Every command takes files of any name, prints the name as it stands, and lets no name steer the terminal."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from instrument.cli.main import status
from instrument.config import InstalledPlugin, PluginLine, discovery, find_plugin
from instrument.views.terminal import plain
from protocols import Availability
from tests.hostile.names import NAMES, STEERING
from tests.support.benches import SMALL, bench_toml, plan_toml

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows knows no such names")

Told = Callable[..., str]
SHORT = SMALL.model_copy(update={"frames": 40, "image_size": 16})


@pytest.fixture
def told(capsys: pytest.CaptureFixture[str]) -> Told:
    """Run the command, check its exit code, and give all that it said, on one line."""

    def run(*arguments: object, code: int = 0) -> str:
        assert status([str(argument) for argument in arguments]) == code
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        both = said.out + said.err
        assert not STEERING & set(both)
        return " ".join(both.split())

    return run


def inputs(folder: Path) -> list[object]:
    return ["--bench", bench_toml(folder), "--plan", plan_toml(folder, SHORT)]


@pytest.mark.parametrize(
    "numbers", [(0, 4, 8), *(pytest.param((k,), marks=pytest.mark.thorough) for k in range(len(NAMES)))], ids=str
)
def test_run_and_analyse_print_a_name_as_it_stands(tmp_path: Path, told: Told, numbers: tuple[int, ...]) -> None:
    name = " ".join(NAMES[number] for number in numbers)
    folder = tmp_path / name
    out = folder / f"{name}.h5"  # a name with a slash is a folder and a name
    out.parent.mkdir(parents=True)
    assert f"frames in {plain(str(out))}" in told("run", *inputs(folder), "--out", out)
    assert out.exists()
    assert "recording" in told("run", *inputs(folder), "--out", out, "--json", "--overwrite")
    assert plain(out.name).plain in told("run", *inputs(folder), "--out", out, code=2)  # it exists
    said = told("analyse", out)
    assert f"drawn {plain(str(out.parent / f'{out.stem}-summary.png'))}" in said
    assert plain(f"Analysis of {out.name}").plain in said.replace("\n", " ")
    assert "pictures" in told("analyse", out, "--json")


def test_check_and_mistakes_print_a_name_as_it_stands(tmp_path: Path, told: Told) -> None:
    for name in NAMES:
        folder = tmp_path / name
        plan = folder / f"{name}.toml"
        plan.parent.mkdir(parents=True)
        assert "Checks" in told("check", *inputs(folder))
        plan.write_text('frames = "\\u001b[2J[/b]"\n"[bold]\\u001b" = 3\n')
        said = told("check", "--bench", bench_toml(folder), "--plan", plan, code=2)
        assert f"2 mistakes in {plain(str(plan))}" in said
        assert "[bold]" in said
        assert plain(str(plan)).plain in told("analyse", plan, code=2)
        assert plain(str(folder / "no")).plain in told("analyse", folder / "no", code=2)


def test_a_scene_and_a_driver_of_any_name_are_told_as_they_stand(tmp_path: Path, told: Told) -> None:
    for written in ("[/b]x", "\\u001b[2J", "[bold]"):
        said = told(
            "check", "--plan", plan_toml(tmp_path), "--bench", bench_toml(tmp_path, f'object = "{written}"'), code=2
        )
        assert (written.replace("\\u001b", "\\x1b")) in said
        bench = bench_toml(tmp_path)
        bench.write_text(bench.read_text().replace('driver = "simulated"', f'driver = "{written}"', 1))
        assert written.replace("\\u001b", "\\x1b") in told(
            "check", "--plan", plan_toml(tmp_path), "--bench", bench, code=2
        )


@pytest.mark.thorough
def test_a_demo_into_a_folder_of_any_name_ends_well(tmp_path: Path, told: Told) -> None:
    folder = tmp_path / NAMES[0] / NAMES[-3]
    said = told("demo", "--out", folder)
    assert f"kinopix analyse {plain(str(folder / 'again.h5'))}" in said


def test_what_plug_ins_say_of_themselves_is_printed_as_it_stands(told: Told, monkeypatch: pytest.MonkeyPatch) -> None:
    plugin = find_plugin("stage", "simulated")
    strange = InstalledPlugin("stage", "[/b]\x1b[2J", "dist[bold]", "1[/]", plugin.entry_point)
    ready = PluginLine(strange, "sum[/x]mary", Availability(ready=True, version="[/]"))
    broken = PluginLine(strange, "sum[/x]mary", error="Error: [/y]\x1b")
    monkeypatch.setattr(discovery, "list_plugins", lambda: (ready, broken))
    monkeypatch.setattr("instrument.config.list_plugins", lambda: (ready, broken))
    said = told("drivers")
    name = "[/b]\\x1b[2J"
    for written in (
        f"{name} │ sum[/x]mary (dist[bold] 1[/], [/]) │ ready │",
        f"{name} │ sum[/x]mary (dist[bold] 1[/]) │ not ready │",
        f"{name}: Error: [/y]\\x1b",
    ):
        assert written in said
    assert "no device found" in told("drivers", "probe")


@pytest.mark.parametrize("name", NAMES[:7])
def test_a_command_or_an_option_of_any_name_is_a_mistake(told: Told, name: str) -> None:
    assert "No such command" in told(name, code=2)
    assert "--bench" in told("run", name, code=2)


def test_a_name_that_is_no_text_is_refused_before_anything_moves(tmp_path: Path, told: Told) -> None:
    out = tmp_path / "\udcff\udcfe.h5"
    assert "/\\udcff\\udcfe.h5', which has bytes that are no text" in told(
        "run", *inputs(tmp_path), "--out", out, code=2
    )
    assert not list(tmp_path.glob("*.h5"))


def test_nothing_but_steering_is_written_out() -> None:
    assert plain("Grüße: 像, é, \N{FAMILY}, a\tb\nc [x] :cat:").plain == "Grüße: 像, é, \N{FAMILY}, a\tb\nc [x] :cat:"
    assert plain("\x1b[2J\x9b\u202e\udcff\r").plain == "\\x1b[2J\\x9b\\u202e\\udcff\\r"
