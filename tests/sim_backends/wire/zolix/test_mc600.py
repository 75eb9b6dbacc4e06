"""MC600 transcripts, byte for byte as ka400z.md 3B has them."""

import numpy as np
import pytest

from tests.sim_backends.wire.zolix.host import mc600


@pytest.mark.parametrize(
    ("sent", "answered"),
    [
        (b"Hello\r", b"OK\r"),
        (b"hello\r", b"OK\r"),
        (b"SetUnit X,m\r", b"OK\r"),
        (b"SetStageStyle X,T\r", b"OK\r"),
        (b"SetStagePitch X,4\r", b"OK\r"),
        (b"SetStageStepsRev X,1600\r", b"OK\r"),
        (b"SetStageDriveRat X,180\r", b"OK\r"),
        (b"SetStageDistance X,256000\r", b"OK\r"),
        (b"SetStageWorkState Y,O\r", b"OK\r"),
        (b"SetOffset Y,45000\r", b"OK\r"),
        (b"SetSpeed X,960\r", b"OK\r"),
        (b"SetInitSpeed X,800\r", b"OK\r"),
        (b"SetAccSpeed X,12000\r", b"OK\r"),
        (b"SetHomeSpeed X,800\r", b"OK\r"),
        (b"SetOrigin X,P\r", b"OK\r"),
        (b"Setsechhomemode X,2\r", b"OK\r"),
        (b"SetUserOrigin X,0\r", b"OK\r"),
        (b"SetUserLimitAble X,E\r", b"OK\r"),
        (b"SetUserPositiveLimit X,124800\r", b"OK\r"),
        (b"SetUserNegativeLimit X,-131200\r", b"OK\r"),
        (b"LoadDefault\r", b"OK\r"),
        (b"Position? X\r", b"POSITION? X,0.000,OK\r"),
        (b"position? x\r", b"POSITION? X,0.000,OK\r"),
        (b"Stop X\r", b"OK\r"),
        (b"VE\r", b"E01\r"),
        (b"Position? Q\r", b"E01\r"),
        (b"SetUnit X,q\r", b"E01\r"),
        (b"SetSpeed X,0\r", b"E01\r"),
        (b"SetSpeed X\r", b"E01\r"),
        (b"GoPosition X,O,R,P,-1\r", b"E01\r"),
        (b"GoPosition X,O,R,Q,1\r", b"E01\r"),
        (b"GoPosition X,O,R,P\r", b"E01\r"),
        (b"GonAxisHome Y,N\r", b"E01\r"),
        (b"SetUserOrigin X,1\r", b"E01\r"),
        (b"SetStagePitch X,0\r", b"E01\r"),
        (b"SetNothing? X\r", b"E01\r"),
        (b"\x80\xff\r", b"E01\r"),
        (b"\nHello\r", b"OK\r"),
        (b"\rHello\r", b"OK\r"),
    ],
)
def test_one_command_has_one_answer(sent: bytes, answered: bytes) -> None:
    """And nothing is left over."""
    host = mc600()
    assert host.ask(sent) == answered
    assert host.rest() == b""


def test_a_query_gives_back_what_was_set() -> None:
    """The comment in the sheet's source: SETUSERNEGATIVELIMIT? X,-45000.1,OK."""
    host = mc600(unit="u")
    for sent in (b"SetUserNegativeLimit X,-45000.1\r", b"SetStagePitch Y,4\r", b"SetStageStepsRev Y,1600\r"):
        assert host.ask(sent) == b"OK\r"
    assert host.ask(b"SetUserNegativeLimit? X\r") == b"SETUSERNEGATIVELIMIT? X,-45000.1,OK\r"
    assert host.ask(b"SetStagePitch? Y\r") == b"SETSTAGEPITCH? Y,4,OK\r"
    assert host.ask(b"SetUnit? X\r") == b"SETUNIT? X,U,OK\r"


def test_a_move_is_ready_at_once_and_tells_its_end() -> None:
    """1000 pulses: READY, then ``X 1000.0,OK`` by itself; the second move counts from there."""
    host = mc600(unit="s")
    assert host.ask(b"GoPosition X,O,R,P,1000\r") == b"READY\r"
    assert host.line() == b"X 1000.0,OK\r"
    assert host.ask(b"goposition x,o,a,p,10.000000\r") == b"READY\r"
    assert host.line() == b"X 10.0,OK\r"
    assert host.ask(b"GoPosition X,O,A,N,5\r") == b"READY\r"
    assert host.line() == b"X -5.0,OK\r"
    assert host.ask(b"GoPosition X,O,R,P,0\r") == b"READY\r"
    assert host.line() == b"X -5.0,OK\r"
    assert host.rest() == b""


def test_the_end_comes_when_the_profile_says() -> None:
    """100 mm at 25 mm/s, 50 mm/s^2, no initial speed: 4.5 s after the command was understood."""
    host = mc600()
    for sent in (b"SetSpeed X,25\r", b"SetInitSpeed X,0\r", b"SetAccSpeed X,50\r"):
        assert host.ask(sent) == b"OK\r"
    sent_s = host.clock.now_s()
    command = b"GoPosition X,O,R,P,100\r"
    assert host.ask(command) == b"READY\r"
    assert host.line() == b"X 100.000,OK\r"
    line_s = (len(command) + len(b"X 100.000,OK\r")) * 10 / 19_200
    assert host.clock.now_s() - sent_s == pytest.approx(4.5 + 0.002 + line_s)


def test_position_is_answered_during_motion_and_a_stop_ends_it() -> None:
    """Half-way the three positions differ; after the stop the line of the end tells where it stands."""
    host = mc600()
    for sent in (b"SetSpeed X,25\r", b"SetInitSpeed X,0\r", b"SetAccSpeed X,50\r"):
        host.ask(sent)
    host.port.write(b"GoPosition X,O,R,P,100\r")
    start_s = host.controller.received_s + 0.002
    assert host.line() == b"READY\r"
    host.clock.advance_to(start_s + 2.0)
    host.port.write(b"Position? X\r")
    asked_s = host.controller.received_s + 0.002 - start_s
    counted_mm = round((25 * asked_s - 6.25) * 400) / 400  # whole pulses of 2.5 um
    assert host.line() == f"POSITION? X,{counted_mm:.3f},OK\r".encode()
    assert host.controller.commanded_mm() == 100
    assert 43 < host.controller.reported_mm() < 45
    host.port.write(b"Stop X\r")
    stopped_s = host.controller.received_s + 0.002 - start_s
    assert host.line() == b"OK\r"
    end_mm = round(25 * stopped_s * 400) / 400  # 6.25 mm of lag and 6.25 mm of braking cancel
    assert host.line() == f"X {end_mm:.3f},OK\r".encode()
    assert host.rest() == b""


def test_a_moving_axis_refuses_what_it_cannot_do() -> None:
    """E02 for a second move, for homing and for a setting; another axis is free."""
    host = mc600()
    assert host.ask(b"GoPosition X,O,R,P,100\r") == b"READY\r"
    for sent in (b"GoPosition X,O,R,P,1\r", b"GoHome X\r", b"SetSpeed X,1\r", b"SetUserOrigin X,0\r", b"LoadDefault\r"):
        assert host.ask(sent) == b"E02\r"
    assert host.ask(b"GoPosition Y,O,R,N,0.5\r") == b"READY\r"
    assert host.line() == b"Y -0.500,OK\r"


def test_homing_finds_the_zero_of_the_mechanics() -> None:
    """The counter began at 0 where the carriage stood, 3 mm from home; afterwards both are 0."""
    host = mc600(start_mm=3.0)
    assert host.ask(b"GoHome X\r") == b"READY\r"
    assert host.line() == b"X 0.000,OK\r"
    assert float(host.controller.true_position_mm(_at(host.clock.now_s()))[0]) == 0.0
    assert host.ask(b"GonAxisHome Y,N,N,N\r") == b"READY\r"
    assert host.line() == b"X 0.000,OK\r"


def test_the_work_origin_is_a_zero_of_its_own() -> None:
    """Set at 2 mm, it is 0 in mode N and 2 in mode P; GoOrigion (so spelled) goes there."""
    host = mc600()
    host.ask(b"GoPosition X,O,A,P,2\r")
    host.line()
    assert host.ask(b"SetUserOrigin X,0\r") == b"OK\r"
    assert host.ask(b"Position? X\r") == b"POSITION? X,2.000,OK\r"
    assert host.ask(b"SetOrigin X,N\r") == b"OK\r"
    assert host.ask(b"Position? X\r") == b"POSITION? X,0.000,OK\r"
    host.ask(b"GoPosition X,O,A,P,1\r")
    assert host.line() == b"X 1.000,OK\r"
    assert host.ask(b"GoOrigion X\r") == b"READY\r"
    assert host.line() == b"X 0.000,OK\r"


def test_a_change_of_unit_leaves_lengths_what_they_are() -> None:
    """960 pulses a second at 400 pulses a millimetre are 2.4 mm/s."""
    host = mc600(unit="s")
    host.ask(b"SetSpeed X,960\r")
    host.ask(b"SetUnit X,m\r")
    assert host.ask(b"SetSpeed? X\r") == b"SETSPEED? X,2.400,OK\r"
    host.ask(b"SetUnit X,u\r")
    assert host.ask(b"SetSpeed? X\r") == b"SETSPEED? X,2400.0,OK\r"


def test_a_wrong_pitch_makes_the_controller_lie() -> None:
    """Told 5 mm on a 4 mm screw, 10 mm on the counter are 8 mm of way."""
    host = mc600()
    host.ask(b"SetStagePitch X,5\r")
    host.ask(b"GoPosition X,O,R,P,10\r")
    assert host.line() == b"X 10.000,OK\r"
    assert float(host.controller.true_position_mm(_at(host.clock.now_s()))[0]) == pytest.approx(8.0)


@pytest.mark.parametrize(("soft_limit", "answered"), [("refuse", b"E02\r"), ("clip", b"READY\r")])
def test_soft_limits_refuse_or_clip(soft_limit: str, answered: bytes) -> None:
    """Which of the two a real box does is unknown."""
    host = mc600(soft_limit=soft_limit)
    for sent in (b"SetUserPositiveLimit X,5\r", b"SetUserLimitAble X,E\r"):
        host.ask(sent)
    assert host.ask(b"GoPosition X,O,A,P,6\r") == answered
    assert host.rest() == (b"X 5.000,OK\r" if soft_limit == "clip" else b"")


def test_a_limit_switch_ends_the_move_there() -> None:
    """The line tells the limit; further is refused, back is not."""
    host = mc600(travel_mm=[-1.0, 2.0])
    assert host.ask(b"GoPosition X,O,R,P,50\r") == b"READY\r"
    assert host.line() == b"X 2.000,OK\r"
    assert host.ask(b"GoPosition X,O,R,P,1\r") == b"E02\r"
    assert host.ask(b"GoPosition X,O,R,N,1\r") == b"READY\r"
    assert host.line() == b"X 1.000,OK\r"


def test_habits_that_nobody_knows_are_settings() -> None:
    """Echo, a silent stop, another error token, EEPROM time, a strict line feed."""
    assert mc600(echo=True).ask(b"Hello\r") == b"Hello\r"
    silent = mc600(stop_reply="", stop_completion=False)
    silent.ask(b"GoPosition X,O,R,P,50\r")
    assert silent.ask(b"Stop X\r") == b""
    assert silent.rest() == b""
    assert mc600(error_syntax="E07").ask(b"Nonsense\r") == b"E07\r"
    assert mc600(strict_lf=True).ask(b"Hello\n\r") == b"E01\r"
    slow = mc600(eeprom_s=0.35)
    slow.port.write(b"SetUnit X,m\rHello\r")
    assert slow.line() == b"OK\r"
    assert slow.clock.now_s() == pytest.approx(12 * 10 / 19_200 + 0.002 + 0.35 + 3 * 10 / 19_200)
    assert slow.line() == b"OK\r"


def _at(time_s: float) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
    return np.array([time_s])
