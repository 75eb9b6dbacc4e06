"""SC300 transcripts, byte for byte as ka400z.md 3A has them."""

import pytest

from tests.sim_backends.wire.zolix.host import sc300


@pytest.mark.parametrize(
    ("sent", "answered"),
    [
        (b"\r", b"OK\r"),
        (b"VE\r", b"SC300_V1.0\r"),
        (b"TY\r", b"SC300\r"),
        (b"ID\r", b"ID0000\r"),
        (b"VX,20000\r", b"OK\r"),
        (b"AX,30000\r", b"OK\r"),
        (b"FX,2500\r", b"OK\r"),
        (b"XV\r", b"XV,8000\r"),
        (b"XF\r", b"XF,1000\r"),
        (b"XA\r", b"XA,16000\r"),
        (b"?X\r", b"?X,0\r"),
        (b"SPX\r", b"?X,0\r"),
        (b"Hello\r", b"ER\r"),
        (b"VY,20000\r", b"ER\r"),
        (b"?Y\r", b"ER\r"),
        (b"ve\r", b"ER\r"),
        (b"VX,fast\r", b"E0\r"),
        (b"VX,0\r", b"E0\r"),
        (b"+X,-5\r", b"E0\r"),
        (b"+X,9999999\r+X,1\r", b""),
        (b"+X,0\r", b""),
        (b"VE\n\r", b"ER\r"),
        (b"\nVE\r", b"ER\r"),
    ],
)
def test_one_command_has_one_answer(sent: bytes, answered: bytes) -> None:
    """And, but for the moves, nothing is left over."""
    host = sc300(travel_mm=[-30_000.0, 30_000.0])
    assert host.ask(sent) == answered
    if not sent.startswith(b"+X,9"):
        assert host.rest() == b""


def test_a_move_answers_when_it_has_ended() -> None:
    """Nothing until then; the position is in the line. 1000 pulses at 8000/s and 16000/s^2 are a triangle."""
    host = sc300()
    host.port.write(b"+X,1000\r")
    assert host.line(0.1) == b""
    assert host.line() == b"?X,1000\r"
    host.port.write(b"-X,250\r")
    assert host.line() == b"?X,750\r"
    assert host.ask(b"?X\r") == b"?X,750\r"
    assert host.rest() == b""


def test_the_end_comes_when_the_profile_says() -> None:
    """Section 5.1: V = 10000, A = 20000 with a lead of 4 mm are 25 mm/s and 50 mm/s^2: 100 mm take 4.5 s (v0 is 1 Hz)."""
    host = sc300()
    for sent in (b"VX,10000\r", b"AX,20000\r", b"FX,1\r"):
        assert host.ask(sent) == b"OK\r"
    host.port.write(b"+X,40000\r")
    sent_s = host.clock.now_s()
    assert host.line() == b"?X,40000\r"
    assert host.clock.now_s() - sent_s == pytest.approx(4.5 + 0.002 + 18 * 10 / 19_200, abs=1e-4)


def test_a_mute_box_drops_what_comes_while_it_moves() -> None:
    """No answer to a query, nor to a lone CR; the completion line is the next thing that comes."""
    host = sc300()
    host.port.write(b"+X,8000\r?X\r\r")
    assert host.line() == b"?X,8000\r"
    assert host.rest() == b""


def test_a_queueing_box_answers_afterwards() -> None:
    """The query and a second move wait; so does what comes after the second move."""
    host = sc300(busy_policy="queue")
    host.port.write(b"+X,8000\r?X\r-X,3000\r?X\r")
    assert [host.line() for _ in range(4)] == [b"?X,8000\r", b"?X,8000\r", b"?X,5000\r", b"?X,5000\r"]
    assert host.rest() == b""


def test_an_answering_box_answers_at_once() -> None:
    """The position on the way, a refusal of a second move, and no OK for a lone CR."""
    host = sc300(busy_policy="answer")
    host.port.write(b"+X,8000\r")
    host.clock.sleep_s(0.5)
    on_the_way = host.ask(b"?X\r")
    assert on_the_way.startswith(b"?X,")
    assert 0 < int(on_the_way[3:]) < 8000
    assert host.ask(b"-X,1\r") == b"E1\r"
    assert host.ask(b"\r") == b"?X,8000\r"
    assert host.rest() == b""


def test_a_stop_is_answered_by_one_line_with_the_position() -> None:
    """Even a mute box stops; by setting it says OK first, or does not hear at all.

    The stop acts 1 s + (4 - 9) bytes of 0.52 ms after the move: 1968.75 pulses of ramp, 0.5599 s at 8000 a second, and
    1968.75 of braking.
    """
    host = sc300()
    host.port.write(b"+X,80000\r")
    host.clock.sleep_s(1.0)
    stopped = host.ask(b"SPX\r")
    assert stopped == b"?X,8417\r"
    assert host.rest() == b""
    polite = sc300(stop_reply="OK")
    polite.port.write(b"+X,80000\r")
    polite.clock.sleep_s(1.0)
    assert polite.ask(b"SPX\r") == b"OK\r"
    assert polite.line() == stopped
    deaf = sc300(stop_works_moving=False)
    deaf.port.write(b"+X,40000\rSPX\r")
    assert deaf.line() == b"?X,40000\r"


def test_home_answers_with_the_zero() -> None:
    """HX: nothing until done."""
    host = sc300(start_mm=2.0)
    host.port.write(b"HX\r")
    assert host.line() == b"?X,0\r"
    echoing = sc300(start_mm=2.0, completion_first="echo")
    echoing.port.write(b"HX\r")
    assert echoing.line() == b"HX,0\r"
    echoing.port.write(b"+X,10\r")
    assert echoing.line() == b"+X,10\r"


def test_a_zero_move_may_complete() -> None:
    """By setting; the default is that no line comes."""
    assert sc300(zero_move_completes=True).ask(b"+X,0\r") == b"?X,0\r"


def test_a_limit_switch_ends_the_move_there() -> None:
    """2 mm are 800 pulses."""
    host = sc300(travel_mm=[-1.0, 2.0])
    host.port.write(b"+X,5000\r")
    assert host.line() == b"?X,800\r"
    assert host.ask(b"+X,1\r") == b"E1\r"
    host.port.write(b"-X,100\r")
    assert host.line() == b"?X,700\r"


def test_a_line_feed_is_passed_over_where_the_setting_says_so() -> None:
    """The strict box answers ER, which is tested above."""
    assert sc300(strict_lf=False).ask(b"VE\r\n") == b"SC300_V1.0\r"
