"""Packets against the check sums that the fact sheet lists."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.zaber.codec import Continuation, Reply, checksum, command, parse


@pytest.mark.parametrize(
    ("text", "digits"),
    [
        ("01 tools echo", "8F"),
        ("1 home", "06"),
        ("1 0 00 home", "36"),
        ("1 0 01 move abs 10000", "C0"),
        ("1 0 02 get pos", "2B"),
        ("1 0 03 stop", "16"),
        ("01 0 01 OK BUSY -- 0", "E7"),
        ("01 0 02 OK IDLE -- 10000", "4A"),
        ("01 0 02 RJ IDLE -- BADDATA", "58"),
    ],
)
def test_checksums_are_those_of_the_sheet(text: str, digits: str) -> None:
    assert checksum(text) == digits


def test_a_command_has_address_id_and_checksum() -> None:
    assert command(1, 0, 1, "move abs 10000") == b"/1 0 01 move abs 10000:C0\n"


def test_a_rejection_keeps_its_flag_and_its_reason() -> None:
    assert parse(b"@01 1 12 RJ BUSY WR BADCOMMAND") == Reply(
        device=1, axis=1, message_id=12, accepted=False, busy=True, warning="WR", data="BADCOMMAND"
    )


def test_a_long_reply_says_that_more_comes() -> None:
    reply, rest = parse(b"@01 0 07 OK IDLE -- part1\\"), parse(b"#01 0 07 cont part2")
    assert isinstance(reply, Reply)
    assert (reply.data, reply.more) == ("part1", True)
    assert rest == Continuation(1, 0, 7, "part2")


@pytest.mark.parametrize(
    "line",
    [
        b"!01 0 IDLE --",
        b"#01 0 an info",
        b"@01 0 OK IDLE -- 0",  # no id: not an answer to us
        b"@01 0 02 OK IDLE -- 10000:4B",
        b"@01 0 02 OK SLOW -- 0",
        b"",
        b"\xff@01 0 02 OK IDLE -- 0",
    ],
)
def test_what_is_no_reply_to_us_is_none(line: bytes) -> None:
    assert parse(line) is None


@given(st.integers(-(10**9), 10**9), st.integers(0, 99), st.integers(0, 40), st.integers(1, 255))
def test_no_single_wrong_byte_becomes_another_answer(microsteps: int, message_id: int, place: int, flip: int) -> None:
    text = f"01 1 {message_id:02d} OK IDLE -- {microsteps}"
    line = f"@{text}:{checksum(text)}".encode()
    place %= len(line)
    wrong = line[:place] + bytes([line[place] ^ flip]) + line[place + 1 :]
    heard = parse(wrong, unchecked=False)
    assert heard is None
    truth = parse(line, unchecked=False)
    assert isinstance(truth, Reply)
    assert truth.data == str(microsteps)
