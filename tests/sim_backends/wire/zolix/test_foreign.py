"""Call sequences of foreign clients on the emulated boxes, with what their authors expect.

geyuuu/pySC300: a command, then bytes up to the CR; the answer is the second field as a number where there is a comma, else the
whole word. Every call blocks until its answer. KYKY's SEM code (MC600): sets, queries and lines over two axes.
"""

import pytest

from tests.sim_backends.wire.zolix.host import Host, mc600, sc300


def answer(host: Host, command: str) -> int | str:
    """As pySC300 reads it: empty the input, send, wait for a CR."""
    host.port.reset_input_buffer()
    host.port.write(f"{command}\r".encode())
    first, comma, second = host.line().rstrip(b"\r").decode().partition(",")
    return int(second) if comma else first


def move_to(host: Host, target: int) -> int | str:
    """An absolute move is a relative one by what is missing, its sign a letter; none is sent for no distance."""
    missing = target - int(answer(host, "?X"))
    return answer(host, f"{'+' if missing > 0 else '-'}X,{abs(missing)}") if missing else target


def test_pysc300_s_session() -> None:
    host = sc300()
    assert [answer(host, word) for word in ("VE", "TY", "ID")] == ["SC300_V1.0", "SC300", "ID0000"]
    for command in ("VX,20000", "AX,30000", "FX,2500"):
        assert answer(host, command) == "OK"
    assert [answer(host, word) for word in ("XV", "XA", "XF")] == [20_000, 30_000, 2500]
    assert answer(host, "+X,1000") == 1000
    assert answer(host, "-X,400") == 600
    assert answer(host, "?X") == 600
    assert [move_to(host, target) for target in (5000, -200, -200, 0)] == [5000, -200, -200, 0]
    assert answer(host, "SPX") == 0
    assert isinstance(answer(host, "HX"), int)
    assert answer(host, "?X") == 0


def test_a_set_up_that_is_read_back_verb_by_verb() -> None:
    """The whole set-up of an axis, 350 ms between commands, then each register read."""
    host = mc600()
    setup = {
        "SetUnit": "u", "SetStageStyle": "T", "SetStagePitch": "4", "SetStageStepsRev": "1600", "SetSpeed": "15000.0",
        "SetInitSpeed": "6000.0", "SetAccSpeed": "10000.0", "SetHomeSpeed": "4000.0", "SetUserPositiveLimit": "124800.0",
    }  # fmt: skip
    for verb, value in setup.items():
        assert host.ask(f"{verb} Y,{value}\r".encode()) == b"OK\r"
        host.clock.sleep_s(0.35)
    for verb, value in setup.items():
        assert host.ask(f"{verb}? Y\r".encode()) == f"{verb.upper()}? Y,{value.upper()},OK\r".encode()


def test_the_work_origin_is_told_and_zero_mode_n_counts_from_it() -> None:
    """2.5 mm from the physical zero."""
    host = mc600()
    assert host.ask(b"SetUserOrigin? X\r") == b"SETUSERORIGIN? X,0.000,OK\r"
    host.ask(b"GoPosition X,O,R,P,2.5\r")
    assert host.line() == b"X 2.500,OK\r"
    assert host.ask(b"SetUserOrigin X,0\r") == b"OK\r"
    assert host.ask(b"SetUserOrigin? X\r") == b"SETUSERORIGIN? X,2.500,OK\r"
    assert host.ask(b"SetOrigin X,N\r") == b"OK\r"
    assert host.ask(b"Position? X\r") == b"POSITION? X,0.000,OK\r"


def test_two_axes_go_along_a_line_and_arrive_together() -> None:
    """``GoInterpolationline2 X,1.0,Y,2.0``: X is half-way when Y is."""
    host = mc600()
    assert host.ask(b"GoInterpolationline2 X,1.0,Y,-2.0\r") == b"READY\r"
    assert {host.line(), host.line()} == {b"X 1.000,OK\r", b"Y -2.000,OK\r"}
    assert host.ask(b"GoInterpolationline3 X,41,Y,18,Z,0\r") == b"READY\r"
    assert host.line() == b"Z 0.000,OK\r"
    host.clock.sleep_s(1.0)
    told = [host.ask(f"Position? {axis}\r".encode()).split(b",")[1] for axis in "XY"]
    assert (float(told[0]) - 1.0) / 40 == pytest.approx((float(told[1]) + 2.0) / 20, abs=0.02)
    assert {host.line(), host.line()} == {b"X 41.000,OK\r", b"Y 18.000,OK\r"}


@pytest.mark.parametrize(
    "command",
    [
        b"GoInterpolationline2 X,1,X,2",
        b"GoInterpolationline2 X,1,Y",
        b"GoInterpolationline2 X,1,Q,2",
        b"GoInterpolationline3 X,1,Y,2",
        b"GoInterpolationline2 X,a,Y,2",
        b"SetUserOrigin? Q",
    ],
)
def test_a_line_that_is_none_is_not_understood(command: bytes) -> None:
    assert mc600().ask(command + b"\r") == b"E01\r"
