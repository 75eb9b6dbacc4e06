"""A new bench is asked and measured: every driver on its emulator, and devices that do otherwise than is taken for granted."""

import json
from pathlib import Path

import pytest

from instrument.commissioning import CommissioningReport, DeviceReport, Effect, commission
from instrument.roles import RoleName
from protocols import Answer

BENCHES = Path(__file__).parents[3] / "examples" / "benches"
LAMP = """[scene]
object = "letter-B"
noise = { kind = "poisson", peak_counts = 200, dead_time_s = 2e-8, peak_in_s = 5e-5, seed = 5 }
"""
"""A steady lamp: 4 million photons a second with all mirrors on."""


def agreed(_effect: Effect, _what: str) -> bool:
    return True


def written(folder: Path, text: str) -> Path:
    path = folder / "bench.toml"
    path.write_text(text)
    return path


def of(report: CommissioningReport, role: RoleName) -> DeviceReport:
    (device,) = (device for device in report.devices if device.role == role)
    return device


def answer(report: CommissioningReport, role: RoleName, name: str) -> Answer:
    return of(report, role).measured[name].answer


def counter_bench(folder: Path, counter: str, scene: str = LAMP) -> Path:
    return written(folder, f'[modulator]\ndriver = "simulated"\n[counter]\n{counter}\n{scene}')


@pytest.mark.parametrize(
    ("name", "only"),
    [
        ("alp-ni-mc600", None),
        ("alp-usbctr-sc300", "counter"),
        ("alp-usbctr-sc300", "stage"),
        ("dlpc900", "modulator"),
        ("ni-analog", "counter"),
        ("serial-counter", "counter"),
        ("zaber", "stage"),
        ("grbl", "stage"),
        pytest.param("simulated", None, marks=pytest.mark.thorough),
        pytest.param("mixed", None, marks=pytest.mark.thorough),
    ],
)
def test_every_driver_is_commissioned_on_its_emulator_and_nothing_is_left_that_a_program_could_answer(
    name: str, only: RoleName | None, tmp_path: Path
) -> None:
    slow = 'driver = "ni-analog"\n', 'driver = "ni-analog"\nsample_rate_hz = 100_000\n'  # a fifth of the samples
    report = commission(written(tmp_path, (BENCHES / f"{name}.toml").read_text().replace(*slow)), agreed, only=only)
    assert not report.failed
    for device in report.devices:
        assert device.identity is not None
        assert {finding.state for finding in device.measured.values()} <= {"answered", "doubtful"}
        for asked in device.questions:
            needs_modulator = asked.see in {"pulses", "order"} and only == "modulator"  # and a counter
            expected = {"not asked"} if needs_modulator else {"answered", "doubtful"}
            assert asked.finding.state in expected or (asked.finding.state == "by hand" and asked.by_hand)
        if device.role == "stage":
            moved = answer(report, "stage", "travel").figures
            assert moved["expected_s"] == pytest.approx(
                0.65
            )  # 2 mm at 5 mm/s and 20 mm/s^2: 0.4 s of cruise and 2 x 0.125 s
            assert 0.65 <= float(str(moved["move_s"])) < 0.85
            assert moved["longest_error_mm"] == pytest.approx(0, abs=0.003)
        if device.role == "counter":
            assert answer(report, "counter", "pulses").figures["bins"] == (1000.0,) * 5
            assert answer(report, "counter", "pulses").figures["edges"] == (1001.0,) * 5
            assert answer(report, "counter", "order").figures["bright_bin"] == 7


def test_the_dead_time_is_that_of_the_light_of_two_halves(tmp_path: Path) -> None:
    """20 ns in the scene: with 4 million photons a second, of which 7.4 % are lost, it is known to 5 % in half a second each."""
    report = commission(counter_bench(tmp_path, 'driver = "simulated"'), agreed, only="counter")
    figures = answer(report, "counter", "dead time").figures
    assert figures["dead_time_s"] == pytest.approx(2e-8, abs=3 * float(str(figures["sigma_s"])))
    assert 2e-10 < float(str(figures["sigma_s"])) < 2e-9
    assert figures["white_hz"] == pytest.approx(4e6 / (1 + 4e6 * 2e-8), rel=2e-3)
    assert answer(report, "counter", "dead time").doubts == ()


def test_a_dead_time_that_is_not_the_stated_one_is_doubted(tmp_path: Path) -> None:
    bench = counter_bench(tmp_path, 'driver = "simulated"\ndead_time_s = 8e-8')
    assert "differ" in answer(commission(bench, agreed, only="counter"), "counter", "dead time").doubts[0]


def test_a_board_that_samples_at_the_start_is_one_bin_off_and_so_it_says(tmp_path: Path) -> None:
    counter = 'driver = "usb-ctr"\ntransport = "usb-ctr-emulator"\nemulator = { fpga_configured = true, reads_at_start = true }'
    report = commission(counter_bench(tmp_path, counter), agreed, only="counter")
    found = answer(report, "counter", "order")
    assert found.figures["bright_bin"] == 8
    assert "bins are +1 from their pictures" in found.doubts[0]
    (asked,) = (asked for asked in of(report, "counter").questions if "sample at the start" in asked.text)
    assert asked.finding.state == "doubtful"


def test_the_loopback_tells_the_debounce_code_where_the_wire_is_there(tmp_path: Path) -> None:
    counter = """driver = "usb-ctr"
transport = "usb-ctr-emulator"
[counter.emulator]
fpga_configured = true
timer_wires = [{ timer = 0, counter = 0 }]
"""
    report = commission(counter_bench(tmp_path, counter), lambda _effect, _what: False, only="counter")
    first, second = of(report, "counter").questions[:2]
    assert first.finding.answer.figures["codes_that_count"] == (16.0,)
    assert first.finding.answer.figures["scan_done_masks"] == "0x20"
    assert (second.see, second.finding) == ("question 1", first.finding)  # asked once


def test_without_consent_nothing_is_shown_and_nothing_moves() -> None:
    asked: list[tuple[Effect, str]] = []

    def refuse(effect: Effect, what: str) -> bool:
        asked.append((effect, what))
        return False

    report = commission(BENCHES / "alp-ni-mc600.toml", refuse)
    assert [effect for effect, _ in asked] == ["light", "motion", "homing"]
    assert "between 0.000 and 2.000 mm at up to 5 mm/s" in asked[1][1]
    states = {name: finding.state for device in report.devices for name, finding in device.measured.items()}
    assert {name for name, state in states.items() if state == "answered"} == {"identity", "standing"}
    assert {state for name, state in states.items() if name not in {"identity", "standing"}} == {"not asked"}
    assert not report.failed


def test_a_stage_is_brought_back_to_where_it_stood(tmp_path: Path) -> None:
    stage = '[stage]\ndriver = "simulated"\nposition_mm = 399.5\n[scene]\n'
    report = commission(written(tmp_path, stage), agreed)
    assert answer(report, "stage", "homing").figures["position_before_mm"] == pytest.approx(399.5)
    assert "and is back there" in answer(report, "stage", "homing").said
    stopped = answer(report, "stage", "stop").figures
    assert stopped["of_mm"] == pytest.approx(2.0)
    assert 1.0 <= float(str(stopped["stopped_after_mm"])) < 1.7


def test_one_that_does_not_open_is_reported_and_the_others_are_measured(tmp_path: Path) -> None:
    others = '[counter]\ndriver = "simulated"\n[stage]\ndriver = "simulated"\n[scene]\n'
    bench = written(tmp_path, f'[modulator]\ndriver = "dlp7000"\nlibrary = "none.so"\n{others}')
    report = commission(bench, agreed)
    assert report.failed
    assert "none.so" in of(report, "modulator").measured["identity"].answer.said
    assert of(report, "counter").measured["order"].state == "failed"
    assert of(report, "stage").measured["travel"].state == "answered"
    assert {asked.finding.state for asked in of(report, "modulator").questions} <= {"failed", "not asked", "by hand"}


@pytest.mark.parametrize(
    ("fault", "name", "told"),
    [
        (
            "{ kind = 'drop-edge', picture = 100 }",
            "pulses",
            "1000 pictures and the guard must give 1000 bins and 1001 edges",
        ),
        ("{ kind = 'drop-edge', picture = 5 }", "order", "31 bins of 32 pictures"),
    ],
)
def test_a_sync_line_that_loses_edges_is_told(tmp_path: Path, fault: str, name: str, told: str) -> None:
    bench = counter_bench(tmp_path, 'driver = "simulated"', LAMP + f"faults = [{fault}]\n")
    found = commission(bench, agreed, only="counter").devices[0].measured[name]
    assert found.state in {"doubtful", "failed"}
    assert any(told in text for text in (found.answer.said, *found.answer.doubts))


def test_the_report_is_a_text_to_fill_in_and_the_same_as_json(tmp_path: Path) -> None:
    report = commission(BENCHES / "zaber.toml", agreed, only="stage")
    text, data = report.write(tmp_path / "rack-3")
    assert (text.name, data.name) == ("rack-3.txt", "rack-3.json")
    said = text.read_text()
    assert "7 of 8 questions answered; 4 want a person's look, in part or whole." in said
    assert said.count("____") == 4 * 11
    assert "  1. Model, firmware, microstep size, `get limit.max`.\n" in said
    assert (
        "  3. Do replies carry a checksum when commands do? (Taken: yes; both are understood.)\n      [ok] see question 1"
        in said
    )
    assert CommissioningReport.model_validate(json.loads(data.read_text())) == report
    assert "\n        expected_s = 0.65\n" in said
    assert "limit.max = 6250000" in said  # 400 mm of 15,625 microsteps
