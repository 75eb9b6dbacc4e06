"""Ports, probing, settings and the plug-in."""

import threading
from pathlib import Path

import pytest
import serial
from pydantic import ValidationError

from drivers.zolix.driver import Ka400z
from drivers.zolix.plugin import plugin
from drivers.zolix.settings import Ka400zSettings
from protocols import BenchContext, DeviceError, DriverUnavailable, InputError
from tests.drivers.zolix.scripted import (
    MC600_OPENS,
    PROFILE,
    SC300_OPENS,
    Line,
    ScriptedPort,
    VirtualClock,
    opened,
    settings,
)


@pytest.mark.parametrize(
    "missing",
    ["lead_mm", "microsteps", "travel_mm", "max_velocity_mm_s", "max_acceleration_mm_s2", "home_velocity_mm_s"],
)
def test_what_the_sheet_does_not_know_has_no_default(missing: str) -> None:
    """Leaving it out is an error that names it."""
    values = settings().model_dump()
    del values[missing]
    with pytest.raises(ValidationError, match=missing):
        Ka400zSettings.model_validate(values)


@pytest.mark.parametrize(
    "wrong",
    [
        {"travel_mm": (400.0, 0.0)},
        {"dialect": "sc300", "axis": "T"},
        {"home_position_mm": -1.0},
        {"home_velocity_mm_s": 41.0},
        {"lead_mm": 0.0},
        {"led_mm": 4.0},
    ],
)
def test_settings_that_cannot_be_are_refused(wrong: dict[str, object]) -> None:
    """Before any port is opened."""
    with pytest.raises(ValidationError):
        settings(**wrong)


@pytest.mark.parametrize(
    ("lead_mm", "microsteps", "pulses_per_mm", "pulses_400_mm"),
    [
        (1, 8, 1600, 640000),
        (2, 8, 800, 320000),
        (4, 8, 400, 160000),
        (5, 8, 320, 128000),
        (10, 8, 160, 64000),
        (5, 16, 640, 256000),
    ],
)
def test_the_scale_is_the_sheets_table(lead_mm: float, microsteps: int, pulses_per_mm: int, pulses_400_mm: int) -> None:
    """Section 2, the table of leads."""
    scale = settings(lead_mm=lead_mm, microsteps=microsteps).scale
    assert scale.pulses_per_mm == pulses_per_mm
    assert scale.pulses(400) == pulses_400_mm
    assert scale.mm(pulses_400_mm) == 400


def test_pulses_are_rounded_and_never_cut_off() -> None:
    """2.9999 mm are 1200 pulses, and so is its mirror image."""
    scale = settings().scale
    assert (scale.pulses(2.9999), scale.pulses(-2.9999)) == (1200, -1200)


def test_an_ok_alone_does_not_prove_an_mc600() -> None:
    """An idle SC300 says OK too; without a line that begins POSITION? X there is no MC600. Asked twice, then refused."""
    silent: tuple[Line, ...] = ((b"VE\r", b"ER\r"), (b"Hello\r", b"OK\r"), (b"Position? X\r", b"ER\r"))
    with pytest.raises(DriverUnavailable, match=r"ER OK ER ER OK ER"):
        opened([*silent, *silent])


def test_nobody_on_the_line_is_an_error_that_says_so_and_closes_the_port() -> None:
    """Two rounds of three questions, each with its time-out."""
    clock = VirtualClock()
    port = ScriptedPort(clock, [(b"VE\r",), (b"Hello\r",)] * 2)
    with pytest.raises(DriverUnavailable, match="19200 baud"):
        Ka400z(settings(), BenchContext(clock=clock, transport=port))
    assert port.nothing_left_over()
    assert port.closed


def test_a_lost_first_reply_does_not_make_an_sc300_an_mc600() -> None:
    """The late answer to VE is heard in the next round."""
    transcript: list[Line] = [(b"VE\r",), (b"Hello\r", b"ER\r"), *SC300_OPENS]
    stage, port, _ = opened(transcript)
    assert stage.identity.firmware == "SC300_V1.0"
    assert port.nothing_left_over()


def test_a_given_dialect_is_asked_for_and_no_other() -> None:
    """No VE to an MC600, no Hello to an SC300."""
    _, port, _ = opened(MC600_OPENS[1:], dialect="mc600")
    assert port.nothing_left_over()
    with pytest.raises(DriverUnavailable, match="sc300"):
        opened([(b"VE\r", b"E01\r")] * 2, dialect="sc300")


def test_an_sc300_has_no_axis_t() -> None:
    """Found out only when the controller has told its name."""
    with pytest.raises(InputError, match="axis X, Y or Z"):
        opened(SC300_OPENS[:1], axis="T")


def test_a_port_or_a_transport_is_needed() -> None:
    """No silent default port."""
    with pytest.raises(InputError, match="set port"):
        Ka400z(settings(), BenchContext(clock=VirtualClock()))


def test_a_transport_of_another_kind_is_refused() -> None:
    """A number is neither a URL nor a port."""
    with pytest.raises(InputError, match="type int"):
        Ka400z(settings(), BenchContext(clock=VirtualClock(), transport=7))


def test_a_port_that_is_not_there_is_unavailable(tmp_path: Path) -> None:
    """The message names it."""
    with pytest.raises(DriverUnavailable, match="no-such-port"):
        Ka400z(settings(port=str(tmp_path / "no-such-port")), BenchContext(clock=VirtualClock()))


def test_a_pyserial_url_is_opened_by_pyserial() -> None:
    """``loop://`` says back what is sent, so no controller is found: the port did work."""
    with pytest.raises(DriverUnavailable, match=r"VE Hello"):
        Ka400z(settings(), BenchContext(clock=VirtualClock(), transport="loop://"))
    with pytest.raises(DriverUnavailable, match=r"VE Hello"):
        Ka400z(settings(port="loop://"), BenchContext(clock=VirtualClock()))


def test_the_plugin_tells_its_library_and_touches_no_device() -> None:
    """Listing ports sends nothing."""
    assert plugin.availability().version == f"pyserial {serial.__version__}"
    assert all(isinstance(line, str) for line in plugin.probe())
    clock = VirtualClock()
    port = ScriptedPort(clock, SC300_OPENS)
    stage = plugin.open(settings(), BenchContext(clock=clock, transport=port))
    assert stage.identity.name == "stage"


def test_stop_from_another_thread_goes_out_while_somebody_waits_for_an_answer() -> None:
    """The waiting call goes on, and gets its answer."""
    stage, port, clock = opened(SC300_OPENS)
    port.expect((b"?X\r", b"?X,0\r"), (b"SPX\r",))
    clock.sleep_s(0.05)

    def stop_elsewhere() -> None:
        stopper = threading.Thread(target=stage.stop)
        stopper.start()
        stopper.join(timeout=5)
        assert not stopper.is_alive()
        assert port.nothing_left_over()

    clock.meanwhile = stop_elsewhere
    assert stage.position().reported_mm == 0
    assert clock.meanwhile is None


def test_a_stop_between_the_call_and_the_move_keeps_the_move_from_beginning() -> None:
    """It comes while the speeds are set; no motion command follows."""
    stage, port, clock = opened(SC300_OPENS)
    port.expect(
        (b"?X\r", b"?X,0\r"),
        (b"AX,20000\r", b"OK\r"),
        (b"SPX\r", b"OK\r"),
        (b"VE\r", b"SC300_V1.0\r"),
        (b"FX,0\r", b"OK\r"),
        (b"VX,10000\r", b"OK\r"),
    )

    def stop_after_the_first_setting() -> None:
        if len(port.lines_left) > 4:
            clock.meanwhile = stop_after_the_first_setting
        else:
            stage.stop()

    clock.meanwhile = stop_after_the_first_setting
    with pytest.raises(DeviceError, match="a stop before the move had begun"):
        stage.move_to(2.5, PROFILE)
    assert port.nothing_left_over()
