"""The self-test: a counter counts one of the board's own timers."""

import pytest

from drivers.usb_ctr.board import UsbCtrBoard
from drivers.usb_ctr.self_test import self_test
from protocols import DeviceTimeout
from tests.drivers.h10682.clock import ScriptClock
from tests.drivers.usb_ctr.script import OPEN, START, STOP, Line, ScriptedPipe, words


def loopback(code: str, during: bytes, after: bytes) -> list[Line]:
    start = list(START)
    start[4] = (
        "21 0 0 64000000" + "00000000" + "7f250000" + "0000",
        None,
    )
    return [(f"18 0 0 00010000{code}", None), *start, ("40 0 0", during), ("40 0 0", after)]


def test_the_self_test_finds_the_code_that_counts_and_the_bit_of_an_ended_scan() -> None:
    script: list[Line] = [
        ("2d 0 2 09000000" + "00" * 12, None),
        ("28 1 2", None),
        *loopback("10", during=b"\x02\x01", after=b"\x40\x01"),
        *loopback("00", during=b"\x02\x01", after=b"\x40\x01"),
        *STOP,
        ("28 0 2", None),
    ]
    pipe = ScriptedPipe([OPEN[0], *script], [*words(3, *[960] * 99), *words(0, *[0] * 99)])
    result = self_test(UsbCtrBoard(pipe), ScriptClock(), counter=0, timer=2)
    assert result.mean_counts == {16: 960.0, 0: 0.0}
    assert result.codes_that_count == (16,)
    assert result.scan_done_masks == (0x40,)
    assert pipe.script == []


def test_a_self_test_without_samples_times_out_and_stops_the_timer() -> None:
    script: list[Line] = [
        ("2d 0 0 09000000" + "00" * 12, None),
        ("28 1 0", None),
        *loopback("10", during=b"\x02\x01", after=b"\x40\x01")[:-1],
        *STOP,
        ("28 0 0", None),
    ]
    pipe = ScriptedPipe([OPEN[0], *script], list(words(1, 2)))
    with pytest.raises(DeviceTimeout, match=r"2 samples after 0\.03 s"):
        self_test(UsbCtrBoard(pipe), ScriptClock(), counter=0, timer=0)
    assert pipe.script == []
