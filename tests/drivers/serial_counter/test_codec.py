"""The lines of the protocol, against its page and against a CRC reckoned bit by bit."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.serial_counter.codec import bin_of, crc8, line, words_of
from sim_backends.wire.serial_counter.box import crc

PAGE = (Path(__file__).parents[3] / "docs" / "reference" / "serial-counter.md").read_text(encoding="utf-8")
SHOWN = re.findall(r"^(host|counter) +(\S.*\*[0-9A-F]{2})$", PAGE, re.MULTILINE)


def test_the_pages_own_example_is_made_of_good_lines() -> None:
    assert len(SHOWN) == 8
    for _, shown in SHOWN:
        assert words_of(shown.encode()) is not None, shown


def test_the_check_value_of_the_page() -> None:
    assert "F4" in PAGE
    assert crc8(b"123456789") == 0xF4


@given(st.binary(max_size=64))
def test_the_table_gives_what_firmware_reckons_bit_by_bit(data: bytes) -> None:
    assert crc8(data) == crc(data)


@given(
    st.integers(0, 2**32 - 1),
    st.integers(0, 2**32 - 1),
    st.integers(0, 2**32 - 1),
    st.integers(0, 400),
    st.integers(1, 255),
)
def test_a_bin_survives_the_line_and_no_single_wrong_byte_does(
    index: int, count: int, ticks: int, at: int, flip: int
) -> None:
    data = line(index, count, ticks)
    assert data.endswith(b"\n")
    words = words_of(data[:-1])
    assert words is not None
    assert bin_of(words) == (index, count, ticks)
    at %= len(data) - 1
    assert words_of(data[:at] + bytes([data[at] ^ flip]) + data[at + 1 : -1]) is None


@pytest.mark.parametrize(
    "data", [b"", b"stop", b"stop*", b"stop*a5", b"stop*A50", b"*00" + b"0" * 62, b"x" * 63 + b"*00"]
)
def test_what_is_no_line_means_nothing(data: bytes) -> None:
    assert words_of(data) is None


@pytest.mark.parametrize(
    "words", [["0", "1"], ["0", "1", "-2"], ["0", "1", "x"], ["armed", "2", "3"], ["0", "4294967296", "1"]]
)
def test_what_is_no_bin_is_none(words: list[str]) -> None:
    assert bin_of(words) is None


def test_a_line_of_64_bytes_is_the_longest() -> None:
    assert words_of(line("x" * 61)[:-1]) is not None
    assert words_of(line("x" * 62)[:-1]) is None
