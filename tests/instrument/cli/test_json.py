"""``--json``: every command has it, and prints one object with the warnings."""

import json
from pathlib import Path
from typing import Any

import pytest
import typer

from instrument.cli.main import app, status
from tests.support.benches import bench_toml, plan_toml

MC600 = Path(__file__).parents[3] / "examples" / "benches" / "alp-ni-mc600.toml"


def commands() -> dict[str, Any]:
    """Every command, and those below it, by what a person types."""
    found: dict[str, Any] = {}
    waiting: list[tuple[str, Any]] = [("", typer.main.get_command(app))]
    while waiting:
        name, command = waiting.pop()
        below: dict[str, Any] | None = getattr(command, "commands", None)
        if below is None or (name and any("--json" in each.opts for each in command.params)):
            found[name.strip()] = command
        waiting += [(f"{name} {each}", inner) for each, inner in (below or {}).items()]
    return found


def test_every_command_has_it_but_the_one_that_prints_json_anyway() -> None:
    without = [
        name for name, command in commands().items() if not any("--json" in each.opts for each in command.params)
    ]
    assert without == ["schema"]
    assert len(commands()) >= 24


def test_the_commands_of_a_new_bench_print_one_object_with_warnings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A stage that was never homed is warned of; nothing else has anything to warn of."""
    monkeypatch.chdir(tmp_path)
    bench, plan = str(bench_toml(tmp_path)), str(plan_toml(tmp_path))
    small = ("--image-size", "32", "--superpixel", "4")
    assert status(["run", "--bench", bench, "--plan", plan, "--out", "run.h5"]) == 0

    def asked(*arguments: str) -> dict[str, Any]:
        capsys.readouterr()
        assert status([*arguments, "--json"]) == 0
        printed: dict[str, Any] = json.loads(capsys.readouterr().out)
        return printed

    moved = asked("move", "12.5", "--bench", str(MC600))
    assert (moved["position_mm"], moved["homed"], moved["travel_mm"]) == (12.5, False, [0.0, 400.0])
    assert "does not know its origin" in moved["warnings"][0]
    shown = asked("show", "white", "--bench", bench, "--seconds", "1", *small)
    assert (shown["side_mirrors"], shown["dark"], shown["warnings"]) == (128, True, [])
    assert asked("export", "run.h5", "--csv", "--npz")["written"] == {"csv": "run.csv", "npz": "run.npz"}
    needed = asked("init", "new", "--stage", "ka400z")["needed"]
    assert needed[:3] == ["travel_mm", "max_velocity_mm_s", "max_acceleration_mm_s2"]
    assert needed[3:] == ["lead_mm", "microsteps", "home_velocity_mm_s"]
    assert asked("new-driver", "m1", "--kind", "stage")["folder"] == "m1"
    assert asked("drivers", "probe").keys() == {"devices", "warnings"}
    assert len(asked("drivers")["plugins"]) > 10
    assert asked("check", "run.h5")["warnings"] == []


def test_a_picture_until_an_interrupt_has_no_end_to_print(tmp_path: Path) -> None:
    assert status(["show", "white", "--bench", str(bench_toml(tmp_path)), "--json"]) == 2
