"""bench.toml is resolved whole, or refused with every mistake in all its tables."""

import json
from pathlib import Path

import pytest

from instrument.config import ConfigError, load_bench

pytestmark = pytest.mark.usefixtures("acme")

GOOD = """\
[modulator]
driver = "acme-projector"
port = "COM3"

[counter]
driver = "acme-counter"
threshold_v = 0.3

[stage]
driver = "acme-axis"
on_abort = "home"
travel_mm = [0.0, 50.0]
transport = "acme-wire"

[stage.emulator]
answer_delay_s = 0.2

[scene]
kind = "acme-desk"
object = "letter-B"
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "bench.toml"


def problems_of(path: Path, text: str) -> list[str]:
    """Each mistake in ``text`` as it is shown, without the folder."""
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_bench(path)
    return [str(problem).removeprefix(f"{path.parent}/") for problem in caught.value.problems]


def test_a_bench_of_plug_ins_with_their_own_settings(path: Path) -> None:
    path.write_text(GOOD)
    bench = load_bench(str(path))
    assert bench.devices["modulator"].plugin.summary == "Acme projector"
    assert bench.devices["modulator"].settings.model_dump() == {"port": "COM3", "sync_width_us": 5.0}
    assert bench.devices["modulator"].transport is None
    assert bench.devices["counter"].settings.model_dump()["threshold_v"] == 0.3
    assert bench.devices["stage"].settings.model_dump() == {"travel_mm": (0.0, 50.0)}
    assert bench.devices["stage"].transport is not None
    assert bench.devices["stage"].transport.settings.model_dump() == {"answer_delay_s": 0.2}
    assert bench.on_abort == "home"
    assert bench.scene is not None
    assert bench.scene.settings.model_dump() == {"object": "letter-B"}
    assert bench.folder == path.parent


def test_what_may_be_left_out(path: Path) -> None:
    path.write_text(
        '[modulator]\ndriver = "acme-projector"\nport = "a"\n[counter]\ndriver = "acme-counter"\n'
        '[stage]\ndriver = "acme-axis"\ntransport = "acme-wire"\n'
    )
    bench = load_bench(path)
    assert bench.scene is None
    assert bench.on_abort == "stop"
    assert bench.devices["stage"].transport is not None
    assert bench.devices["stage"].transport.settings.model_dump() == {"answer_delay_s": 0.01}


def test_the_recording_gets_names_versions_and_all_settings(path: Path) -> None:
    path.write_text(GOOD)
    assert json.loads(load_bench(path).as_json())["stage"] == {
        "name": "acme-axis",
        "distribution": "kinopix-acme",
        "version": "1.2.0",
        "settings": {"travel_mm": [0.0, 50.0]},
        "transport": {
            "name": "acme-wire",
            "distribution": "kinopix-acme",
            "version": "1.2.0",
            "settings": {"answer_delay_s": 0.2},
        },
        "on_abort": "home",
    }


def test_the_mistakes_of_all_tables_come_at_once(path: Path) -> None:
    text = (
        GOOD.replace('port = "COM3"', "prt = 3")
        .replace("threshold_v = 0.3", "threshold_mv = 300\ndead_time_s = 0")
        .replace('"home"', '"hom"')
        .replace("answer_delay_s = 0.2", 'answer_delay_s = "slow"')
        .replace("acme-desk", "acme-dsk")
        + "[laser]\npower_mw = 5\n"
    )
    found = problems_of(path, text)
    assert [problem.split(";")[0].split(" (")[0] for problem in found] == [
        "bench.toml:1: modulator.port: saw nothing",
        "bench.toml:3: modulator.prt: saw an unknown key",
        "bench.toml:7: counter.threshold_mv: saw an unknown key",
        "bench.toml:8: counter.dead_time_s: saw 0",
        'bench.toml:12: stage.on_abort: saw "hom"',
        'bench.toml:17: stage.emulator.answer_delay_s: saw "slow"',
        "bench.toml:20: scene.kind: saw 'acme-dsk', a scene plug-in that no installed distribution offers",
        "bench.toml:22: laser: saw an unknown key",
    ]
    assert "did you mean threshold_v, in V? Convert the value from mV" in found[2]
    assert "did you mean 'home'?" in found[4]
    assert "did you mean 'acme-desk'?" in found[6]
    assert "expected one of modulator, counter, stage, scene" in found[7]


def test_settings_of_an_emulator_are_checked_against_its_own_model(path: Path) -> None:
    assert problems_of(path, GOOD.replace("answer_delay_s = 0.2", "answer_delay_ms = 200")) == [
        (
            "bench.toml:16: stage.emulator.answer_delay_ms: saw an unknown key; expected one of answer_delay_s "
            "(did you mean answer_delay_s, in s? Convert the value from ms)"
        )
    ]


def test_a_misspelt_key_of_the_framework_is_suggested_too(path: Path) -> None:
    (problem,) = problems_of(path, GOOD.replace("on_abort =", "on_abrt ="))
    assert (
        "stage.on_abrt: saw an unknown key; expected one of travel_mm, driver, transport, emulator, on_abort" in problem
    )
    assert "did you mean on_abort?" in problem


def test_a_transport_that_is_no_name_is_one_mistake(path: Path) -> None:
    assert problems_of(path, GOOD.replace('"acme-wire"', "3")) == [
        "bench.toml:13: stage.transport: saw 3; expected text in quotes"
    ]


def test_a_missing_driver_names_the_line_and_what_is_installed(path: Path) -> None:
    (problem,) = problems_of(path, GOOD.replace('"acme-counter"', '"acme-countr"'))
    assert problem.startswith("bench.toml:6: counter.driver: saw 'acme-countr', a counter plug-in that no installed")
    assert "did you mean 'acme-counter'?" in problem
    assert "simulated" in problem


def test_a_broken_driver_names_distribution_and_cause(path: Path) -> None:
    (problem,) = problems_of(path, GOOD.replace('"acme-counter"', '"acme-no-library"'))
    assert "counter plug-in 'acme-no-library' of kinopix-acme 1.2.0, which gives ImportError: libacme.so" in problem


def test_a_missing_transport_names_the_line(path: Path) -> None:
    (problem,) = problems_of(path, GOOD.replace('"acme-wire"', '"acme-wires"'))
    assert problem.startswith("bench.toml:13: stage.transport: saw 'acme-wires'")


def test_an_emulator_needs_a_transport(path: Path) -> None:
    assert problems_of(path, GOOD.replace('transport = "acme-wire"\n', "")) == [
        (
            "bench.toml:14: stage.emulator: saw settings of a transport, but no transport; "
            'expected transport = "..." in [stage]'
        )
    ]


def test_a_bench_needs_its_three_devices(path: Path) -> None:
    found = problems_of(path, '[modulatr]\ndriver = "x"\n[counter]\ndrivr = "acme-counter"\n')
    assert [problem.split(": ", 1)[1] for problem in found] == [
        "modulator: saw nothing; expected a value for modulator (is modulatr meant to be modulator?)",
        "stage: saw nothing; expected a value for stage",
        (
            "modulatr: saw an unknown key; expected one of modulator, counter, stage, scene, light, calibration, "
            "magnification (did you mean modulator?)"
        ),
        "counter.driver: saw nothing; expected a value for driver (is drivr meant to be driver?)",
    ]


def test_a_device_that_is_no_table(path: Path) -> None:
    (problem,) = problems_of(path, 'modulator = "acme"\n' + GOOD[GOOD.index("[counter]") :])
    assert problem == 'bench.toml:1: modulator: saw "acme"; expected a table'
