"""Each fault of ka400z.md 3F, as bytes and positions."""

import numpy as np
import pytest
import serial

from tests.sim_backends.wire.zolix.host import Host, mc600, sc300


def _moved(host: Host) -> bytes:
    assert host.ask(b"GoPosition X,O,R,P,1\r") == b"READY\r"
    return host.rest()


def test_a_reply_may_be_lost() -> None:
    """The second answer to Position? never comes; the third does. So may the line of a motion's end."""
    host = mc600(
        faults=[{"kind": "lost-reply", "at": "Position?", "nth": 2}, {"kind": "lost-reply", "at": "completion"}]
    )
    assert [host.ask(b"Position? X\r") != b"" for _ in range(3)] == [True, False, True]
    assert _moved(host) == b""


def test_a_byte_may_be_corrupted() -> None:
    """Bit 4 of the first byte of the first answer: O becomes an underscore."""
    host = mc600(faults=[{"kind": "corrupted-byte"}])
    assert host.ask(b"Hello\r") == b"_K\r"
    assert host.ask(b"Hello\r") == b"OK\r"


def test_a_completion_may_come_after_the_next_query() -> None:
    """The answer to the query comes first."""
    host = mc600(faults=[{"kind": "late-completion", "delay_s": 5.0}])
    host.ask(b"GoPosition X,O,R,P,1\r")
    host.clock.sleep_s(2.0)
    assert host.ask(b"Position? X\r") == b"POSITION? X,1.000,OK\r"
    assert host.line() == b"X 1.000,OK\r"


def test_a_completion_may_come_twice() -> None:
    """Only the named one."""
    host = mc600(faults=[{"kind": "duplicated-completion", "nth": 2}])
    assert _moved(host) == b"X 1.000,OK\r"
    assert _moved(host) == b"X 2.000,OK\rX 2.000,OK\r"


def test_a_box_may_fall_silent_and_still_obey() -> None:
    """From the second command on nothing is heard, but the carriage goes."""
    host = mc600(faults=[{"kind": "mute", "nth": 2}])
    assert host.ask(b"Hello\r") == b"OK\r"
    assert host.ask(b"GoPosition X,O,R,P,1\r") == b""
    assert host.rest() == b""
    assert host.controller.reported_mm() == 1.0


def test_a_box_may_fall_silent_behind_the_second_of_a_kind() -> None:
    """Other commands are not counted, however they are written; the second move is answered, its end and all else is not."""
    host = mc600(faults=[{"kind": "mute", "at": "goposition", "nth": 2, "behind": True}])
    assert _moved(host) == b"X 1.000,OK\r"
    assert host.ask(b"Position? X\r") == b"POSITION? X,1.000,OK\r"
    assert _moved(host) == b"X 2.000,OK\r"
    assert host.ask(b"Hello\r") == b""
    assert host.ask(b"GoPosition X,O,R,P,1\r") == b""
    host.rest()
    assert host.controller.reported_mm() == 3.0


def test_a_stall_is_seen_only_by_the_truth() -> None:
    """The controller reports 1 mm, the carriage stands at a quarter of it."""
    host = mc600(faults=[{"kind": "stall", "after": 0.25}])
    assert _moved(host) == b"X 1.000,OK\r"
    now_s = np.array([host.clock.now_s()])
    positions = (host.controller.commanded_mm(), host.controller.reported_mm())
    assert (*positions, float(host.controller.true_position_mm(now_s)[0])) == (1.0, 1.0, 0.25)


def test_a_screw_is_not_quite_its_nominal_lead() -> None:
    """One permille of 1 mm is a micrometre."""
    host = mc600(lead_error=0.001)
    assert _moved(host) == b"X 1.000,OK\r"
    assert float(host.controller.true_position_mm(np.array([host.clock.now_s()]))[0]) == pytest.approx(1.001)


def test_a_limit_switch_may_stick() -> None:
    """No motion leads away from it any more."""
    host = sc300(travel_mm=[-1.0, 2.0], faults=[{"kind": "limit-sticks"}])
    host.port.write(b"+X,5000\r")
    assert host.line() == b"?X,800\r"
    assert host.ask(b"-X,100\r") == b"E1\r"


def test_the_port_may_vanish() -> None:
    """At the second command; afterwards every use of the port raises what pyserial would."""
    host = mc600(faults=[{"kind": "port-vanishes", "nth": 2}])
    assert host.ask(b"Hello\r") == b"OK\r"
    with pytest.raises(serial.SerialException, match="gone"):
        host.port.write(b"Hello\r")
    with pytest.raises(serial.SerialException, match="gone"):
        host.port.read(1)
    with pytest.raises(serial.SerialException, match="gone"):
        _ = host.port.in_waiting
    host.port.close()


def test_the_port_may_vanish_at_a_command_by_name_or_behind_it() -> None:
    """At it, the command is not carried out; behind it, it is."""
    for behind, place_mm in ((False, 0.0), (True, 1.0)):
        host = mc600(faults=[{"kind": "port-vanishes", "at": "GoPosition", "behind": behind}])
        assert host.ask(b"Hello\r") == b"OK\r"
        if behind:
            assert _moved(host) == b"X 1.000,OK\r"
        with pytest.raises(serial.SerialException, match="gone"):
            host.port.write(b"GoPosition X,O,R,P,1\r")
        assert host.controller.reported_mm() == place_mm
