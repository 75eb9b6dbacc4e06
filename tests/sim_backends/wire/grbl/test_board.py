"""The emulated board, by the sheet's own lines (zaber-and-grbl.md, sections 3 and 5)."""

from typing import Any

import numpy as np
import pytest

from sim_backends.bench import VirtualClock
from sim_backends.wire.grbl import GrblBoard, GrblEmulatorSettings
from tests.sim_backends.wire.serial_host import Host


def host(**settings: Any) -> Host:
    """A board that has started, without homing unless asked."""
    values: dict[str, Any] = {"homing": False, **settings}
    there = Host(GrblBoard(GrblEmulatorSettings.model_validate(values), VirtualClock()).box)
    there.rest(1.0)
    return there


def test_power_gives_the_welcome_and_the_lock() -> None:
    board = GrblBoard(GrblEmulatorSettings(), VirtualClock())
    there = Host(board.box)
    there.port.write(b"?")  # nobody hears this yet
    assert there.rest(1.0) == b"\r\nGrbl 1.1f ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n"
    assert there.ask(b"$J=G91X1F60\n") == b"error:8\r\n"
    assert there.ask(b"?").startswith(b"<Alarm|")
    assert there.ask(b"$X\n") == b"[MSG:Caution: Unlocked]\r\n"
    assert there.line() == b"ok\r\n"
    assert there.ask(b"?").startswith(b"<Idle|")


@pytest.mark.parametrize(
    ("sent", "answered"),
    [
        (b"\n", b"ok\r\n"),
        (b"$J=G91 G21 X10.0 F1500\r", b"ok\r\n"),
        (b"$j=g91g20x1f10\n", b"ok\r\n"),
        (b"$J=G91X1\n", b"error:22\r\n"),
        (b"$J=G91F60\n", b"error:26\r\n"),
        (b"$J=G91X1X2F60\n", b"error:25\r\n"),
        (b"$J=G91X1.2.3F60\n", b"error:2\r\n"),
        (b"$J=G91G90X1F60\n", b"error:21\r\n"),
        (b"$J=G2X1F60\n", b"error:16\r\n"),
        (b"$J=\n", b"error:1\r\n"),
        (b"$H\n", b"error:5\r\n"),
        (b"$Q\n", b"error:3\r\n"),
        (b"$120=fast\n", b"error:2\r\n"),
        (b"$120=-1\n", b"error:4\r\n"),
        (b"$999=1\n", b"error:3\r\n"),
        (b"G1X1\n", b"error:20\r\n"),
        (b"$" + b"1" * 130 + b"\n", b"error:11\r\n"),
    ],
)
def test_a_line_has_one_answer(sent: bytes, answered: bytes) -> None:
    assert host().ask(sent) == answered


def test_it_tells_its_settings_and_keeps_what_is_written() -> None:
    there = host()
    there.ask(b"$120=50.5\n")
    there.port.write(b"$$\n")
    told = there.rest(1.0).splitlines()
    assert {b"$100=400.000", b"$110=3000.000", b"$120=50.500", b"$130=400.000", b"$21=1"} <= set(told)
    assert told[-1] == b"ok"


def test_an_ok_is_not_done_and_the_status_line_tells() -> None:
    """10 mm at 25 mm/s and 100 mm/s^2: 10/25 + 25/100 = 0.65 s."""
    there = host()
    assert there.ask(b"$J=G91G21X10F1500\n") == b"ok\r\n"
    there.clock.sleep_s(0.32)
    state, place = there.ask(b"?")[1:].split(b"|")[:2]
    assert state == b"Jog"
    assert 4.5 < float(place[5:].split(b",")[0]) < 5.6
    there.clock.sleep_s(0.33)
    assert there.ask(b"?").startswith(b"<Idle|MPos:10.000,0.000,0.000|FS:0,0")


def test_a_faster_jog_is_clipped_without_a_word() -> None:
    """100 mm at 50 mm/s: 2.5 s, though 100 mm/s was asked."""
    there = host()
    there.ask(b"$J=G90X100F6000\n")
    there.clock.sleep_s(2.4)
    assert there.ask(b"?").startswith(b"<Jog")
    there.clock.sleep_s(0.2)
    assert there.ask(b"?").startswith(b"<Idle")


def test_real_time_bytes_are_taken_out_of_the_middle_of_a_line() -> None:
    there = host()
    there.port.write(b"$J=G91X")
    assert there.ask(b"?").startswith(b"<Idle")
    assert there.ask(b"1F60\n") == b"ok\r\n"


def test_a_jog_cancel_decelerates_and_flushes_and_is_nothing_elsewhere() -> None:
    there = host()
    assert there.ask(b"\x85") == b""
    there.ask(b"$J=G91X10F600\n")
    there.ask(b"$J=G91X10F600\n")
    there.clock.sleep_s(0.4)
    there.port.write(b"\x85")
    there.clock.sleep_s(0.2)
    first = there.ask(b"?")
    assert first.startswith(b"<Idle")
    assert 3.0 < float(first.split(b":")[1].split(b",")[0]) < 5.0
    there.clock.sleep_s(3.0)
    assert there.ask(b"?").split(b"|")[1] == first.split(b"|")[1]


def test_sixteen_jogs_fill_the_planner() -> None:
    there = host()
    there.port.write(b"$J=G91X1F600\n" * 18)
    assert there.rest(0.05).count(b"ok") == 16  # one runs, fifteen wait
    assert there.rest(20.0).count(b"ok") == 2
    assert there.ask(b"?").startswith(b"<Idle|MPos:18.000")


def test_the_offset_comes_now_and_then() -> None:
    there = host(report="WPos", work_offset_mm=10.0)
    lines = [there.ask(b"?") for _ in range(11)]
    assert [b"WCO:10.000,0.000,0.000" in line for line in lines] == [True, *[False] * 9, True]
    assert b"WPos:-10.000," in lines[0]


def test_homing_is_mute_and_its_ok_comes_at_the_end() -> None:
    """5 mm at 10 mm/s and 100 mm/s^2: 0.6 s."""
    there = host(homing=True, start_mm=5.0, home_position_mm=-1.0)
    assert there.ask(b"$X\n").startswith(b"[MSG")
    there.rest(0.1)
    there.port.write(b"$H\n")
    there.port.write(b"?")
    assert there.rest(0.5) == b""
    assert there.rest(0.2) == b"ok\r\n"
    assert b"<Idle|MPos:-1.000" in there.ask(b"?")


def test_a_reset_in_motion_loses_the_position() -> None:
    there = host()
    there.ask(b"$J=G91X10F600\n")
    there.clock.sleep_s(0.3)
    there.port.write(b"\x18")
    assert there.rest(0.1).startswith(b"ALARM:3\r\n\r\nGrbl 1.1f")
    assert there.ask(b"?").startswith(b"<Alarm")


def test_a_reset_in_homing_is_another_alarm() -> None:
    there = host(homing=True, start_mm=50.0)
    there.port.write(b"$H\n")
    there.rest(0.3)
    there.port.write(b"\x18")
    assert there.rest(0.1).startswith(b"ALARM:6\r\n")


def test_a_limit_switch_silences_it_until_a_reset() -> None:
    there = host(travel_mm=[0.0, 5.0])
    there.ask(b"$J=G91X10F600\n")
    assert there.rest(2.0) == b"ALARM:1\r\n[MSG:Reset to continue]\r\n"
    assert there.ask(b"?") == b""
    there.port.write(b"\x18")
    assert b"Grbl 1.1f" in there.rest(0.1)
    assert there.ask(b"?").startswith(b"<Alarm|MPos:5.000")


def test_soft_limits_refuse_without_an_alarm() -> None:
    there = host(soft_limits=True, travel_mm=[0.0, 5.0])
    assert there.ask(b"$J=G91X5.01F600\n") == b"error:15\r\n"
    assert there.ask(b"$J=G91X5F600\n") == b"ok\r\n"


def fault(**keys: Any) -> Host:
    return host(faults=[keys])


def test_faults_strike_what_they_name() -> None:
    assert fault(kind="error", at="$J", code=33).ask(b"$J=G91X1F60\n") == b"error:33\r\n"
    assert fault(kind="lost-reply", at="$J").ask(b"$J=G91X1F60\n") == b""
    late = fault(kind="late-reply", at="$J", delay_s=3.0)
    assert late.ask(b"$J=G91X1F60\n") == b""
    assert late.rest(3.0) == b"ok\r\n"
    assert fault(kind="corrupted-byte", at="$J", byte=0).ask(b"$J=G91X1F60\n") == b"\x7fk\r\n"
    assert fault(kind="mute").ask(b"?") == b""


def test_homing_without_a_switch_is_alarm_9() -> None:
    there = host(homing=True, start_mm=5.0, faults=[{"kind": "no-switch"}])
    there.port.write(b"$H\n")
    assert there.rest(2.0) == b"ALARM:9\r\n"


def test_a_board_that_resets_by_itself_says_so() -> None:
    there = fault(kind="reset", nth=2)
    there.ask(b"$J=G91X10F600\n")
    there.port.write(b"?")
    assert there.rest(0.1).startswith(b"ALARM:3\r\n\r\nGrbl 1.1f")


def test_a_stall_is_not_seen() -> None:
    """The counter goes on; the carriage does not."""
    told: list[Any] = []
    board = GrblBoard(
        GrblEmulatorSettings.model_validate({"homing": False, "faults": [{"kind": "stall"}]}),
        VirtualClock(),
        told.append,
    )
    there = Host(board.box)
    there.rest(1.0)
    there.ask(b"$J=G91X10F600\n")
    there.clock.sleep_s(3.0)
    assert there.ask(b"?").startswith(b"<Idle|MPos:10.000")
    assert abs(float(told[-1](np.array([there.clock.now_s()]))[0]) - 5.0) < 0.01


def test_a_port_that_vanishes_raises() -> None:
    there = fault(kind="port-vanishes", nth=2)
    there.ask(b"?")
    with pytest.raises(OSError, match="gone"):
        there.ask(b"?")
