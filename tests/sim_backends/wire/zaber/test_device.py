"""The emulated controller, by the sheet's own packets (zaber-and-grbl.md, sections 2 and 5)."""

from typing import Any

import numpy as np
import pytest

from protocols import Floats
from sim_backends.bench import VirtualClock
from sim_backends.wire.zaber import ZaberDevice, ZaberEmulatorSettings
from tests.sim_backends.wire.serial_host import Host


def host(**settings: Any) -> Host:
    values: dict[str, Any] = {"referenced": True, **settings}
    return Host(ZaberDevice(ZaberEmulatorSettings.model_validate(values), VirtualClock()).box)


@pytest.mark.parametrize(
    ("sent", "answered"),
    [
        (b"/\n", b"@01 0 OK IDLE -- 0\r\n"),
        (b"/1\r\n", b"@01 0 OK IDLE -- 0\r\n"),
        (b"/1 1 12 badly\n", b"@01 1 12 RJ IDLE -- BADCOMMAND\r\n"),
        (b"/01 tools echo:8F\n", b"@01 0 OK IDLE -- 0:8D\r\n"),
        (b"/1 1 get limit.max\r", b"@01 1 OK IDLE -- 6250000\r\n"),
        (b"/1 1 get system.axiscount\n", b"@01 1 OK IDLE -- 1\r\n"),
        (b"/1 1 move abs 6250001\n", b"@01 1 RJ IDLE -- BADDATA\r\n"),
        (b"/1 1 move abs 6250000\n", b"@01 1 OK BUSY -- 0\r\n"),
        (b"/1 1 move abs far\n", b"@01 1 RJ IDLE -- BADDATA\r\n"),
        (b"/1 1 move rel -1\n", b"@01 1 RJ IDLE -- BADDATA\r\n"),
        (b"/1 1 set maxspeed 0\n", b"@01 1 RJ IDLE -- BADDATA\r\n"),
        (b"/1 1 set maxspeed 2560001\n", b"@01 1 RJ IDLE -- BADDATA\r\n"),
        (b"/1 1 set maxspeed 2560000\n", b"@01 1 OK IDLE -- 0\r\n"),
        (b"/1 warnings\n", b"@01 0 OK IDLE -- 00\r\n"),
        (b"/2 get pos\n", b""),
        (b"/1 0 02 get pos:2C\n", b""),
        (b"/1 0 100 get pos\n", b""),
        (b"/1 get pos/\n", b""),
        (b"get pos\n", b""),
        (b"/1 tools echo " + b"x" * 80 + b"\n", b""),
    ],
)
def test_one_packet_has_one_reply_or_none(sent: bytes, answered: bytes) -> None:
    there = host()
    assert there.ask(sent) == answered
    assert there.rest(0.1) == b""


# By hand from the sheet's `@01 0 02 OK IDLE -- 10000` = 4A: without "1000" it is 4A + C1 = 0B, without the id 0B + 82 = 8D.


def test_a_reply_has_id_and_checksum_where_the_command_had() -> None:
    there = host()
    assert there.ask(b"/1 0 02 get pos:2B\n") == b"@01 0 02 OK IDLE -- 0:0B\r\n"
    assert host(checksums="never").ask(b"/1 0 02 get pos:2B\n") == b"@01 0 02 OK IDLE -- 0\r\n"
    assert host(checksums="always").ask(b"/1 0 02 get pos\n") == b"@01 0 02 OK IDLE -- 0:0B\r\n"


def test_pieces_and_two_commands_in_one_write_are_two_replies() -> None:
    there = host()
    there.port.write(b"/1 1 get p")
    assert there.rest(0.1) == b""
    assert there.ask(b"os\n/1 1 get accel\n") == b"@01 1 OK IDLE -- 0\r\n"
    assert there.line() == b"@01 1 OK IDLE -- 256\r\n"


def test_a_move_runs_its_trapezoid_and_is_busy_until_it_stands() -> None:
    """10 mm/s and 100 mm/s^2 over 10 mm: 1.1 s; half-way after 0.55 s."""
    there = host()
    assert b"BUSY" in there.ask(b"/1 1 move abs 156250\n")
    begun_s = there.clock.now_s()
    there.clock.sleep_s(0.548)  # the reply took 2 ms on the line
    status = there.ask(b"/1 1 get pos\n").split()
    assert status[3] == b"BUSY"
    assert abs(int(status[5]) - 78_125) < 1_000
    there.clock.sleep_s(begun_s + 1.097 - there.clock.now_s())
    assert b"BUSY" in there.ask(b"/\n")
    there.clock.sleep_s(0.02)
    assert there.ask(b"/1 1 get pos\n") == b"@01 1 OK IDLE -- 156250\r\n"


def test_a_stop_decelerates_and_its_reply_carries_the_note() -> None:
    """From 10 mm/s at 100 mm/s^2: 0.5 mm and 0.1 s more."""
    there = host()
    there.ask(b"/1 1 move max\n")
    there.clock.sleep_s(1.0)
    before = int(there.ask(b"/1 1 get pos\n").split()[5])
    assert there.ask(b"/1 1 stop\n") == b"@01 1 OK BUSY NI 0\r\n"
    there.clock.sleep_s(0.2)
    state, flag, after = there.ask(b"/1 1 get pos\n").split()[3:]
    assert (state, flag) == (b"IDLE", b"NI")
    assert 0.5 * 15_625 < int(after) - before < 0.6 * 15_625


def test_a_second_move_takes_the_place_of_the_first_and_leaves_the_note() -> None:
    there = host()
    there.ask(b"/1 1 move abs 156250\n")
    there.clock.sleep_s(0.3)
    assert there.ask(b"/1 1 move abs 0\n") == b"@01 1 OK BUSY NI 0\r\n"
    there.clock.sleep_s(5.0)
    assert there.ask(b"/1 1 get pos\n") == b"@01 1 OK IDLE NI 0\r\n"


def test_power_up_is_without_reference_until_homing_is_over() -> None:
    there = host(referenced=False, start_mm=5.0)
    assert there.ask(b"/1 1 get pos\n") == b"@01 1 OK IDLE WR 0\r\n"
    assert there.ask(b"/1 warnings\n") == b"@01 0 OK IDLE WR 01 WR\r\n"
    assert there.ask(b"/1 1 home\n") == b"@01 1 OK BUSY WR 0\r\n"
    there.clock.sleep_s(5.0)
    assert there.ask(b"/1 1 get limit.home.triggered\n") == b"@01 1 OK IDLE -- 1\r\n"


def test_homing_that_was_stopped_gives_no_reference() -> None:
    there = host(referenced=False, start_mm=5.0)
    there.ask(b"/1 1 home\n")
    there.clock.sleep_s(0.1)
    there.ask(b"/1 1 stop\n")
    there.clock.sleep_s(5.0)
    assert b"WR" in there.ask(b"/\n")


@pytest.mark.parametrize(
    ("settings", "word", "flag"),
    [({"driver_enabled": False}, b"DRIVERDISABLED", b"FO"), ({"parked": True}, b"PARKED", b"--")],
)
def test_what_may_not_move_says_why(settings: dict[str, Any], word: bytes, flag: bytes) -> None:
    there = host(**settings)
    for move in (b"/1 1 move rel 100\n", b"/1 1 home\n"):
        assert there.ask(move).split()[2:] == [b"RJ", b"IDLE", flag, word]


def test_the_motor_current_can_be_switched() -> None:
    there = host(driver_enabled=False)
    assert there.ask(b"/1 driver enable\n") == b"@01 0 OK IDLE -- 0\r\n"
    assert b"BUSY" in there.ask(b"/1 1 move rel 100\n")


def test_the_object_goes_where_the_carriage_goes() -> None:
    told: list[Any] = []
    box = ZaberDevice(ZaberEmulatorSettings(), VirtualClock(), told.append).box
    there = Host(box)
    there.ask(b"/1 1 move abs 15625\n")
    at_mm: Floats = told[-1](np.array([10.0]))
    assert at_mm.tolist() == [1.0]


def test_another_speed_of_the_line_is_not_understood() -> None:
    device = ZaberDevice(ZaberEmulatorSettings(), VirtualClock())
    assert Host(device.box, baud=9600).ask(b"/\n") == b""


def fault(**keys: Any) -> Host:
    return host(faults=[keys])


def test_faults_strike_the_reply_that_they_name() -> None:
    lost = fault(kind="lost-reply", at="get pos", nth=2)
    assert [bool(lost.ask(b"/1 1 get pos\n")) for _ in range(3)] == [True, False, True]
    wrong = fault(kind="corrupted-byte", byte=4)
    assert wrong.ask(b"/1 1 get pos\n") == b"@01 !" + b" OK IDLE -- 0\r\n"
    rejected = fault(kind="rejected", at="move", word="STATUSBUSY")
    assert rejected.ask(b"/1 1 move rel 5\n") == b"@01 1 RJ IDLE -- STATUSBUSY\r\n"
    assert b"OK BUSY" in rejected.ask(b"/1 1 move rel 5\n")


def test_old_replies_alerts_and_infos_come_between() -> None:
    old = fault(kind="old-reply", nth=2)
    old.ask(b"/1 1 07 get pos\n")
    assert old.ask(b"/1 1 08 get pos\n").startswith(b"@01 1 07")
    assert old.line().startswith(b"@01 1 08")
    chatter = fault(kind="chatter")
    assert chatter.ask(b"/1 1 get pos\n") == b"!01 1 IDLE --\r\n"
    assert chatter.line().startswith(b"#01 0")
    assert chatter.line().startswith(b"@01 1 OK")


def test_a_mute_controller_still_obeys() -> None:
    mute = fault(kind="mute", nth=1)
    assert mute.ask(b"/1 1 move rel 15625\n") == b""


def test_a_stall_stops_short_and_says_so() -> None:
    there = fault(kind="stall", after=0.5)
    there.ask(b"/1 1 move abs 15625\n")
    there.clock.sleep_s(2.0)
    assert there.ask(b"/1 1 get pos\n") == b"@01 1 OK IDLE FS 7812\r\n"
    assert there.ask(b"/1 warnings clear\n") == b"@01 0 OK IDLE -- 0\r\n"


def test_a_port_that_vanishes_raises() -> None:
    there = fault(kind="port-vanishes", nth=2)
    there.ask(b"/\n")
    with pytest.raises(OSError, match="gone"):
        there.ask(b"/\n")
