"""The driver on an SC300: pulses only, an answer only at the end of a move, mute on the way."""

import pytest

from drivers.zolix.driver import Ka400z
from protocols import DeviceError, DeviceRefused, DeviceTimeout
from tests.drivers.zolix.scripted import PROFILE, SC300_OPENS, After, Line, ScriptedPort, VirtualClock, opened

AT_ZERO: Line = (b"?X\r", b"?X,0\r")
SPEEDS: tuple[Line, ...] = ((b"AX,20000\r", b"OK\r"), (b"FX,0\r", b"OK\r"), (b"VX,10000\r", b"OK\r"))


def stage_on(*lines: Line, **changes: object) -> tuple[Ka400z, ScriptedPort, VirtualClock]:
    """Give a stage that has been opened and then plays ``lines``."""
    stage, port, clock = opened(SC300_OPENS, **changes)
    assert port.nothing_left_over()
    port.expect(*lines)
    return stage, port, clock


def test_opening_needs_one_question_and_tells_the_firmware() -> None:
    """VE is answered by SC300_V1.0."""
    stage, port, _ = stage_on()
    assert port.nothing_left_over()
    assert stage.identity.model == "KA400Z on SC300"
    assert stage.identity.firmware == "SC300_V1.0"


@pytest.mark.parametrize("first_byte", [b"?", b"+", b"H"])
def test_an_absolute_move_is_the_difference_and_its_answer_comes_at_the_end(first_byte: bytes) -> None:
    """There and back; the first byte of the last line is unknown, so any will do."""
    at_1000: Line = (b"?X\r", b"?X,1000\r")
    stage, port, _ = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"+X,1000\r", After(0.45, first_byte + b"X,1000\r")),
        at_1000,
        at_1000,
        (b"-X,600\r", After(0.35, first_byte + b"X,400\r")),
        (b"?X\r", b"?X,400\r"),
    )
    assert stage.move_to(2.5, PROFILE).wait().reported_mm == 2.5
    back = stage.move_to(1.0, PROFILE).wait()
    assert (back.reported_mm, back.predicted) == (1.0, False)
    assert port.nothing_left_over()


def test_position_during_a_motion_is_predicted_marked_so_and_costs_no_byte() -> None:
    """25 mm/s, 50 mm/s^2: 6.25 mm of ramp in 0.5 s, then 25 mm/s."""
    stage, port, clock = stage_on(AT_ZERO, *SPEEDS, (b"+X,40000\r", After(4.5, b"?X,40000\r")))
    stage.move_to(100, PROFILE)
    line_s = len(b"+X,40000\r") * 10 / 19200
    clock.sleep_s(1.5 + line_s)
    here = stage.position()
    assert here.predicted
    assert here.reported_mm == pytest.approx(6.25 + 25.0)
    assert here.commanded_mm == 100
    assert port.nothing_left_over()


def test_a_move_of_no_pulse_is_over_at_once_because_the_box_would_never_answer() -> None:
    """No motion command is sent."""
    stage, port, _ = stage_on(AT_ZERO)
    assert stage.move_to(0.0, PROFILE).done
    assert port.nothing_left_over()


def test_an_error_in_place_of_the_end_of_the_move_is_a_refusal() -> None:
    """E0 comes instead; the position, told twice, has not changed."""
    stage, port, _ = stage_on(AT_ZERO, *SPEEDS, (b"+X,1000\r", b"E0\r"), AT_ZERO, AT_ZERO)
    with pytest.raises(DeviceRefused, match=r"stands at 0 mm \(code E0\); expected 2.5 mm"):
        stage.move_to(2.5, PROFILE).wait()
    assert port.nothing_left_over()


def test_stop_is_sent_while_the_box_is_mute_and_the_end_is_asked_for_until_it_answers() -> None:
    """The first fence stays unanswered because the stage still slows down."""
    at_400: Line = (b"?X\r", b"?X,400\r")
    stage, port, _ = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"+X,40000\r",),
        (b"SPX\r",),
        (b"VE\r",),
        (b"VE\r", b"SC300_V1.0\r"),
        at_400,
        at_400,
    )
    motion = stage.move_to(100, PROFILE)
    motion.stop()
    with pytest.raises(DeviceError, match="over at 1 mm, after a stop"):
        motion.wait()
    motion.stop()
    assert port.nothing_left_over()


def test_a_stage_that_ignores_the_stop_is_a_timeout_and_not_an_endless_wait() -> None:
    """0.6 s to slow down, one second more, and the time to look twice."""
    stage, port, clock = stage_on(AT_ZERO, *SPEEDS, (b"+X,40000\r",), (b"SPX\r",), *([(b"VE\r",)] * 6))
    motion = stage.move_to(100, PROFILE)
    stage.stop()
    stopped_s = clock.time_s
    with pytest.raises(DeviceTimeout, match="the line that ends the stopped motion to 100 mm"):
        motion.wait()
    assert clock.time_s - stopped_s < 4
    assert port.closed is False


def test_homing_runs_at_homing_velocity_and_ends_with_a_position() -> None:
    """HX; the answer has the form of a position."""
    stage, port, _ = stage_on(
        AT_ZERO,
        (b"AX,40000\r", b"OK\r"),
        (b"FX,0\r", b"OK\r"),
        (b"VX,2000\r", b"OK\r"),
        (b"HX\r", After(3, b"?X,0\r")),
        AT_ZERO,
    )
    assert stage.home().wait().reported_mm == 0
    assert stage.homed
    assert port.nothing_left_over()


def test_homing_that_ends_elsewhere_is_an_error_and_the_stage_is_not_homed() -> None:
    """Where a controller ends is a setting: 0 is the assumption that is tested here."""
    at_120: Line = (b"?X\r", b"?X,120\r")
    stage, port, _ = stage_on(
        AT_ZERO,
        (b"AX,40000\r", b"OK\r"),
        (b"FX,0\r", b"OK\r"),
        (b"VX,2000\r", b"OK\r"),
        (b"HX\r", After(3, b"HX,120\r")),
        at_120,
        at_120,
    )
    with pytest.raises(DeviceError, match=r"over at 0\.3 mm; expected 0 mm.*home_position_mm"):
        stage.home().wait()
    assert not stage.homed
    assert port.nothing_left_over()
