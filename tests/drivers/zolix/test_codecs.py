"""The two dialects as the fact sheet's tables have them (sections 3A and 3B), without any port."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.zolix.events import (
    Arrived,
    Codec,
    Command,
    Event,
    Lines,
    Named,
    Okay,
    Position,
    Ready,
    Refused,
    Unknown,
    Value,
)
from drivers.zolix.mc600 import Mc600Codec
from drivers.zolix.sc300 import Sc300Codec


def codec_named(name: str) -> Codec:
    """Give a fresh codec of axis X."""
    return Mc600Codec("X") if name == "MC600" else Sc300Codec("X")


def received(codec: Codec, data: bytes, lines: Lines | None = None) -> list[Event]:
    """Give the events that ``data`` completes, as the wire takes them in."""
    return [codec.classify(line) for line in (lines or Lines()).feed(data)]


@pytest.mark.parametrize(
    ("line", "event"),
    [
        (b"OK\r", Okay()),
        (b"READY\r", Ready()),
        (b"E01\r", Refused("E01")),
        (b"E02\r", Refused("E02")),
        (b"POSITION? X,12.345,OK\r", Position(12.345)),
        (b"SETUSERNEGATIVELIMIT? X,-45000.1,OK\r", Value("SETUSERNEGATIVELIMIT", "-45000.1")),
        (b"SETUNIT? X,s,OK\r", Value("SETUNIT", "s")),
        (b"X 1000.0,OK\r", Arrived(1000.0)),
        (b"X -1000.0,OK\r", Arrived(-1000.0)),
        (b"Y 1000.0,OK\r", Unknown(b"Y 1000.0,OK")),
        (b"POSITION? Y,1.0,OK\r", Unknown(b"POSITION? Y,1.0,OK")),
        (b"POSITION? X,12.3x5,OK\r", Unknown(b"POSITION? X,12.3x5,OK")),
        (b"POSITION? X,nan,OK\r", Unknown(b"POSITION? X,nan,OK")),
        (b"POSITION? X,12.345\r", Unknown(b"POSITION? X,12.345")),
        (b"O\xcb\r", Unknown(b"O\xcb")),
    ],
)
def test_an_mc600_line_means_what_the_sheet_says(line: bytes, event: Event) -> None:
    """One line, one event; what is damaged or of another axis is Unknown."""
    assert received(Mc600Codec("X"), line) == [event]


@pytest.mark.parametrize(
    ("line", "event"),
    [
        (b"OK\r", Okay()),
        (b"ER\r", Refused("ER")),
        (b"E0\r", Refused("E0")),
        (b"E1\r", Refused("E1")),
        (b"SC300_V1.0\r", Named("SC300_V1.0")),
        (b"SC300\r", Named("SC300")),
        (b"ID0000\r", Named("ID0000")),
        (b"XV,20000\r", Value("XV", "20000")),
        (b"?X,1000\r", Position(1000)),
        (b"?X,-128000\r", Position(-128000)),
        (b"+X,1000\r", Arrived(1000)),
        (b"HX,0\r", Arrived(0)),
        (b"?Y,1000\r", Unknown(b"?Y,1000")),
        (b"?X,10.5\r", Unknown(b"?X,10.5")),
        (b"?X,\r", Unknown(b"?X,")),
    ],
)
def test_an_sc300_line_means_what_the_sheet_says(line: bytes, event: Event) -> None:
    """One line, one event; the first byte of the line at the end of a move may be any."""
    assert received(Sc300Codec("X"), line) == [event]


def test_mc600_intents_are_the_sheets_bytes() -> None:
    """Numbers are unsigned; P or N carries the sign; a motion command is answered by READY."""
    codec = Mc600Codec("X")
    assert codec.set_up() == (Command(b"SetUnit X,s\r", Okay),)
    assert codec.set_velocity(960) == Command(b"SetSpeed X,960\r", Okay)
    assert codec.set_initial_velocity(800) == Command(b"SetInitSpeed X,800\r", Okay)
    assert codec.set_acceleration(12000) == Command(b"SetAccSpeed X,12000\r", Okay)
    assert codec.set_home_velocity(800) == Command(b"SetHomeSpeed X,800\r", Okay)
    assert codec.move_to(1000, standing_at=700) == Command(b"GoPosition X,O,A,P,1000\r", Ready)
    assert codec.move_to(-1000, standing_at=0) == Command(b"GoPosition X,O,A,N,1000\r", Ready)
    assert codec.move_by(1000) == Command(b"GoPosition X,O,R,P,1000\r", Ready)
    assert codec.move_by(-500) == Command(b"GoPosition X,O,R,N,500\r", Ready)
    assert codec.home() == Command(b"GoHome X\r", Ready)
    assert codec.ask_position() == Command(b"Position? X\r", Position)
    assert codec.stop() == b"Stop X\r"
    assert codec.fence() == Command(b"SetUnit? X\r", Value)


def test_sc300_intents_are_the_sheets_bytes() -> None:
    """Numbers are unsigned; the first letter carries the sign; a move is answered by nothing."""
    codec = Sc300Codec("X")
    assert codec.set_up() == ()
    assert codec.set_velocity(20000) == Command(b"VX,20000\r", Okay)
    assert codec.set_acceleration(30000) == Command(b"AX,30000\r", Okay)
    assert codec.set_initial_velocity(2500) == Command(b"FX,2500\r", Okay)
    assert codec.move_to(1000, standing_at=0) == Command(b"+X,1000\r", None)
    assert codec.move_to(0, standing_at=1000) == Command(b"-X,1000\r", None)
    assert codec.move_by(-120000) == Command(b"-X,120000\r", None)
    assert codec.home() == Command(b"HX\r", None)
    assert codec.ask_position() == Command(b"?X\r", Position)
    assert codec.stop() == b"SPX\r"
    assert codec.fence() == Command(b"VE\r", Named)


def test_several_lines_in_one_read_and_a_line_in_pieces_give_the_same_events() -> None:
    """READY now, the position line later, the last one cut in the middle; a stray LF is nothing."""
    codec, lines = Mc600Codec("X"), Lines()
    assert received(codec, b"READY\r\nX -1", lines) == [Ready()]
    assert lines.pending == b"\nX -1"
    assert received(codec, b"000.0,OK\rOK\r\r", lines) == [Arrived(-1000.0), Okay()]
    assert lines.pending == b""


def test_noise_without_a_carriage_return_does_not_pile_up() -> None:
    """After 64 bytes without CR it is no line of either dialect."""
    lines = Lines()
    assert received(Sc300Codec("X"), b"\xff" * 65, lines) == [Unknown(b"\xff" * 64)]
    assert lines.pending == b"\xff"


_NEARLY = st.sampled_from(
    [
        b"OK\r",
        b"READY\r",
        b"X 1000.0,OK\r",
        b"POSITION? X,12.345,OK\r",
        b"?X,1000\r",
        b"E01\r",
        b"ER\r",
        b"SC300_V1.0\r",
        b"\r",
    ]
)
_STREAM = st.lists(_NEARLY | st.binary(max_size=80), max_size=12).map(b"".join)


@pytest.mark.parametrize("name", ["MC600", "SC300"])
@given(stream=_STREAM, cuts=st.lists(st.integers(0, 400), max_size=8))
def test_events_do_not_depend_on_where_the_bytes_are_split(name: str, stream: bytes, cuts: list[int]) -> None:
    """Any bytes, split anywhere: the same events, the same rest, and no crash."""
    codec, whole, pieces = codec_named(name), Lines(), Lines()
    edges = [0, *sorted(min(cut, len(stream)) for cut in cuts), len(stream)]
    split = [event for a, b in pairwise(edges) for event in received(codec, stream[a:b], pieces)]
    assert split == received(codec, stream, whole)
    assert pieces.pending == whole.pending


@pytest.mark.parametrize("name", ["MC600", "SC300"])
@given(line=st.binary(min_size=1, max_size=40).filter(lambda line: b"\r" not in line and line.strip() != b""))
def test_every_line_is_one_event_and_data_only_if_it_is_whole(name: str, line: bytes) -> None:
    """Arbitrary bytes become exactly one event, and a position only where the line is one from end to end."""
    (event,) = received(codec_named(name), line + b"\r")
    if isinstance(event, Position | Arrived):
        assert line.strip().endswith(b",OK") if name == "MC600" else b"X," in line
