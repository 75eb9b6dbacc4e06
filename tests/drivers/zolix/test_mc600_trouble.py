"""The driver on an MC600 that does not answer as it should: lines lost, late, doubled or wrong, motions that end elsewhere."""

import pytest

from protocols import DeviceBusy, DeviceDisconnected, DeviceError, DeviceRefused, DeviceTimeout
from tests.drivers.zolix.mc600 import AT_ZERO, SPEEDS, stage_on
from tests.drivers.zolix.scripted import PROFILE, After, Line


def test_a_controller_that_turns_out_to_be_mute_in_motion_is_predicted_from_then_on() -> None:
    """Asked once, without an answer; then not asked again."""
    stage, port, clock = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,40000\r", b"READY\r", After(4.5, b"X 40000.0,OK\r")),
        (b"Position? X\r", b""),
    )
    stage.move_to(100, PROFILE)
    moving_since_s = clock.time_s  # READY was there some milliseconds ago
    clock.sleep_s(0.5)
    first, second = stage.position(), stage.position()
    assert first.predicted
    assert second.predicted
    # 25 mm/s after a ramp of 0.5 s and 6.25 mm
    assert second.reported_mm == pytest.approx(6.25 + 25 * (second.time_s - moving_since_s - 0.5), abs=0.5)
    assert port.nothing_left_over()


def test_stop_needs_no_answer_and_the_motion_ends_as_an_error_where_the_stage_stands() -> None:
    """Answer to the stop is unknown, so an OK is fenced off; the position is read twice before it is believed."""
    at_400: Line = (b"Position? X\r", b"POSITION? X,400.0,OK\r")
    stage, port, clock = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,40000\r", b"READY\r"),
        (b"Stop X\r", b"OK\rX 400.0,OK\r"),
        (b"SetUnit? X\r", b"SETUNIT? X,s,OK\r"),
        at_400,
        at_400,
    )
    motion = stage.move_to(100, PROFILE)
    before_s = clock.time_s
    stage.stop()
    assert clock.time_s == before_s
    with pytest.raises(DeviceError, match=r"over at 1 mm, after a stop; expected 100 mm"):
        motion.wait()
    assert motion.done
    assert port.nothing_left_over()


def test_a_limit_switch_ends_the_motion_elsewhere_and_that_is_an_error() -> None:
    """The completion line names another place, the controller says it again twice."""
    at_limit: Line = (b"Position? X\r", b"POSITION? X,30000.0,OK\r")
    stage, port, _ = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,40000\r", b"READY\r", After(3, b"X 30000.0,OK\r")),
        at_limit,
        at_limit,
    )
    with pytest.raises(DeviceError, match=r"over at 75 mm; expected 100 mm. To do: look at the limit switches"):
        stage.move_to(100, PROFILE).wait()
    assert port.nothing_left_over()


def test_an_old_completion_line_does_not_end_a_new_motion() -> None:
    """A doubled line arrives in the next move: two positions differ, so the stage still moves."""
    stage, port, _ = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,40000\r", b"READY\r", After(0.1, b"X 0.0,OK\r"), After(4.5, b"X 40000.0,OK\r")),
        (b"Position? X\r", b"POSITION? X,120.0,OK\r"),
        (b"Position? X\r", b"POSITION? X,400.0,OK\r"),
        (b"Position? X\r", b"POSITION? X,40000.0,OK\r"),
    )
    assert stage.move_to(100, PROFILE).wait().reported_mm == 100
    assert port.nothing_left_over()


def test_a_refused_move_is_an_error_with_the_controllers_code() -> None:
    """E02 in place of READY; the stage is free for the next move."""
    stage, port, _ = stage_on(AT_ZERO, *SPEEDS, (b"GoPosition X,O,A,P,1000\r", b"E02\r"), AT_ZERO)
    with pytest.raises(DeviceRefused, match="code E02") as refused:
        stage.move_to(2.5, PROFILE)
    assert refused.value.code == "E02"
    assert stage.position().reported_mm == 0.0
    assert port.nothing_left_over()


def test_a_lost_answer_is_a_timeout_that_names_what_was_awaited_and_what_came() -> None:
    """Half an answer; 0.5 s margin plus (12 + 64) bytes of 10 bits at 19200 baud is 0.54 s."""
    stage, port, clock = stage_on((b"Position? X\r", b"POSITION? X,1"))
    clock.sleep_s(0.05)
    before_s = clock.time_s
    with pytest.raises(DeviceTimeout, match=r"only b'POSITION\? X,1' after 0.54 s; expected Position in answer to"):
        stage.position()
    assert clock.time_s - before_s == pytest.approx(0.54, abs=0.005)
    assert port.nothing_left_over()


def test_an_answer_that_comes_after_its_timeout_is_not_taken_for_the_next_one() -> None:
    """After a time-out the next exchange is fenced: what comes before the fence's answer is old."""
    stage, port, clock = stage_on(
        (b"Position? X\r", After(0.7, b"POSITION? X,77.0,OK\r")),
        (b"SetUnit? X\r", After(0.3, b"SETUNIT? X,s,OK\r")),
        AT_ZERO,
    )
    with pytest.raises(DeviceTimeout):
        stage.position()
    clock.sleep_s(0.1)
    assert stage.position().reported_mm == 0.0
    assert port.nothing_left_over()


def test_a_position_that_contradicts_what_is_known_is_asked_again() -> None:
    """A standing stage was at 0; 900 is one damaged digit, told once and not again."""
    stage, port, _ = stage_on((b"Position? X\r", b"POSITION? X,900.0,OK\r"), AT_ZERO)
    assert stage.position().reported_mm == 0.0
    assert port.nothing_left_over()


def test_a_lost_completion_line_is_a_timeout_that_names_the_way_done() -> None:
    """The profile's 0.45 s plus 20 % plus 1 s; the motion stays refused-to-all until a stop."""
    stage, port, clock = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,1000\r", b"READY\r"),
        (b"Position? X\r", b"POSITION? X,1000.0,OK\r"),
    )
    motion = stage.move_to(2.5, PROFILE)
    started_s = clock.time_s
    with pytest.raises(DeviceTimeout, match=r"2.500 of 2.500 mm done \(reported\)"):
        motion.wait()
    assert clock.time_s - started_s == pytest.approx(1.2 * PROFILE.duration_s(2.5) + 1.0, abs=0.05)
    with pytest.raises(DeviceBusy):
        stage.move_to(0, PROFILE)
    assert port.nothing_left_over()


def test_a_move_whose_ready_is_lost_is_stopped_and_settled_before_the_next() -> None:
    """It may have begun. The next move waits until the stage stands, then goes from there."""
    at_100: Line = (b"Position? X\r", b"POSITION? X,100.0,OK\r")
    stage, port, _ = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,1000\r",),
        (b"Stop X\r",),
        (b"SetUnit? X\r", b"SETUNIT? X,s,OK\r"),
        at_100,
        at_100,
        at_100,
        (b"GoPosition X,O,A,P,1000\r", b"READY\r", After(0.45, b"X 1000.0,OK\r")),
        (b"Position? X\r", b"POSITION? X,1000.0,OK\r"),
    )
    with pytest.raises(DeviceTimeout, match="expected Ready in answer to"):
        stage.move_to(2.5, PROFILE)
    assert stage.move_to(2.5, PROFILE).wait().reported_mm == 2.5
    assert port.nothing_left_over()


def test_a_vanished_port_is_an_error_everywhere_and_is_closed_all_the_same() -> None:
    """Even where the stop cannot be sent."""
    stage, port, _ = stage_on()
    port.broken = True
    for call in (stage.position, stage.stop, lambda: stage.move_to(1, PROFILE)):
        with pytest.raises(DeviceDisconnected, match=r"Input/output error|returned no data"):
            call()
    with pytest.raises(DeviceDisconnected):
        stage.__exit__(None, None, None)
    assert port.closed


def test_an_answer_that_comes_twice_is_over_before_the_next_question() -> None:
    """The second copy ends 12 ms after the first: the line has to be silent for 20 ms, and then a fence goes first."""
    stage, port, clock = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,40000\r", b"READY\r"),
        (b"Position? X\r", After(0.02, b"POSITION? X,4800.0,OK\r"), After(0.032, b"POSITION? X,4800.0,OK\r")),
        (b"SetUnit? X\r", b"SETUNIT? X,s,OK\r"),
        (b"Position? X\r", After(0.02, b"POSITION? X,5200.0,OK\r")),
    )
    stage.move_to(100, PROFILE)
    clock.sleep_s(0.98)
    assert stage.position().reported_mm == 12.0
    assert stage.position().reported_mm == 13.0
    assert port.nothing_left_over()
