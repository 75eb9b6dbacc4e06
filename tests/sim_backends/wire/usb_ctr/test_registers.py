"""Registers of h10682-daq.md 5.2, each by its row of the sheet: debounce, timers, ticks, memory and lines."""

import struct
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim_backends.wire.usb_ctr.debounce import debounce_s
from sim_backends.wire.usb_ctr.timers import Timer
from tests.sim_backends.wire.usb_ctr.rig import STALL, Rig, errno_of

_US = (0.5, 1.5, 3.5, 7.5, 15.5, 31.5, 63.5, 127.5, 100, 300, 700, 1500, 3100, 6300, 12_700, 25_500)


def _count(rig: Rig, counter: int) -> int:
    return int.from_bytes(rig.ask(0x10, 8, 0, counter), "little")


def _words(*numbers: int) -> bytes:
    return struct.pack(f"<{len(numbers)}I", *numbers)


def _timed(period: int, width: int, *, count: int = 0, delay: int = 0) -> Timer:
    """A timer enabled at 0 s."""
    timer = Timer()
    timer.change(0.0, period=period, width=width, count=count, delay=delay)
    timer.change(0.0, control=1)
    return timer


# Debounce


@pytest.mark.parametrize("code", range(16))
def test_a_debounce_code_is_one_step_longer_by_the_maker_s_library(code: int) -> None:
    """The table of the conflict in 5.2, row by row: code k of libuldaq is code k + 1 of wjasper's driver."""
    assert debounce_s(code, "uldaq") == pytest.approx(_US[code] * 1e-6)
    assert debounce_s(code + 1, "wjasper") == pytest.approx(_US[code] * 1e-6)


@pytest.mark.parametrize(("table", "off"), [("uldaq", 16), ("wjasper", 0)])
@pytest.mark.parametrize("trigger_before_stable", [0x00, 0x20])
def test_bit_5_of_a_debounce_code_does_not_change_its_time(
    table: Literal["uldaq", "wjasper"], off: int, trigger_before_stable: int
) -> None:
    """Row 0x13: b5 says whether an edge counts before or after the input is stable. Switched off stays off."""
    assert debounce_s(off | trigger_before_stable, table) == 0
    assert debounce_s(3 | trigger_before_stable, table) == debounce_s(3, table) > 0


@pytest.mark.parametrize(("period", "width", "counted"), [(95, 47, 10_000), (95, 46, 0), (95, 48, 0)])
def test_a_pulse_passes_if_it_and_the_pause_last_as_long_as_the_debounce(period: int, width: int, counted: int) -> None:
    """1 MHz of 96 ticks, code 0 of libuldaq, 500 ns: 48 ticks high and low pass, 47 high or 47 low do not."""
    rig = Rig(timer_wires=[{"timer": 0, "counter": 1}])
    rig.out(0x13, 0, 1)
    rig.out(0x2D, 0, 0, _words(period, width, 0, 0))
    rig.out(0x28, 1)
    rig.bench.clock.sleep_s(0.01)
    assert _count(rig, 1) == counted


# Timers


@given(period=st.integers(2, 10**6), time_s=st.floats(0, 10))
def test_a_timer_gives_96_mhz_over_period_plus_one(period: int, time_s: float) -> None:
    """Row 0x29; a pulse more or less where the moment falls on a tick."""
    pulses = int(_timed(period, 0).pulses(np.array([time_s]))[0])
    assert abs(pulses - time_s * 96e6 / (period + 1)) <= 1.001


def test_a_pulse_is_its_width_plus_one_tick_long_and_the_rest_of_the_period_is_the_pause() -> None:
    """Rows 0x29 and 0x2A: period 9 and width 3 are 10 ticks, 4 of them high."""
    timer = _timed(9, 3)
    assert timer.high_s == pytest.approx(4 / 96e6)
    assert timer.low_s == pytest.approx(6 / 96e6)


def test_a_start_delay_puts_off_the_whole_train() -> None:
    """Row 0x2C: 96,000 clocks are 1 ms. At 10 kHz, 3 ms give 20 pulses, and 1.05 ms none."""
    timer = _timed(9599, 0, delay=96_000)
    assert timer.pulses(np.array([0.0, 0.00105, 0.0011, 0.003])).tolist() == [0, 0, 1, 20]


def test_a_timer_runs_until_its_count_and_then_keeps_it() -> None:
    """Rows 0x28 and 0x2B: b1 is told while pulses come; five at 10 kHz are over after 0.5 ms."""
    timer = _timed(9599, 0, count=5)
    assert timer.pulses(np.array([0.0004, 0.0005, 1.0])).tolist() == [4, 5, 5]
    assert [timer.status(0.00041), timer.status(0.00051)] == [0b11, 0b01]


def test_enabling_a_timer_again_goes_on_with_the_count_of_a_wired_counter() -> None:
    """Five pulses, and five again."""
    timer = _timed(9599, 0, count=5)
    timer.change(1.0, control=0)
    timer.change(2.0, control=1)
    assert timer.pulses(np.array([2.0, 2.00021, 3.0])).tolist() == [5, 7, 10]
    assert timer.status(3.0) == 0b01


def test_an_inverted_timer_keeps_its_bit_and_the_running_bit_cannot_be_written() -> None:
    """Row 0x28: b0 enable, b1 running and read only, b2 inverted."""
    rig = Rig()
    rig.out(0x29, 0, 0, _words(9599))
    rig.out(0x28, 0b110)
    assert rig.ask(0x28, 1) == b"\x04"
    rig.out(0x28, 0b101)
    assert rig.ask(0x28, 1) == b"\x07"


def test_the_registers_of_a_timer_are_its_parameters_in_one() -> None:
    """Rows 0x29 to 0x2D; the other three timers do not notice, and there is no fifth."""
    rig = Rig()
    rig.out(0x2D, 0, 2, _words(1000, 20, 30, 40))
    assert [rig.ask(request, 4, 0, 2) for request in (0x29, 0x2A, 0x2B, 0x2C)] == [
        _words(n) for n in (1000, 20, 30, 40)
    ]
    rig.out(0x2B, 0, 2, _words(31))
    assert rig.ask(0x2D, 16, 0, 2) == _words(1000, 20, 31, 40)
    assert [rig.ask(0x2D, 16, 0, timer) for timer in (0, 1, 3)] == [bytes(16)] * 3
    assert errno_of(rig.ask, 0x2D, 16, 0, 4) == STALL


@pytest.mark.parametrize(("period", "width", "ticks"), [(1, 0, 2), (0, 0, None), (2, 1, 3), (2, 2, None)])
def test_the_shortest_period_is_1_and_a_width_is_shorter(period: int, width: int, ticks: int | None) -> None:
    """Rows 0x29 and 0x2A: all is kept, as clients write in any order; a train without room for a pulse gives none."""
    rig = Rig(timer_wires=[{"timer": 0, "counter": 1}])
    rig.out(0x13, 16, 1)
    data = _words(period, width, 0, 0)
    rig.out(0x2D, 0, 0, data)
    rig.out(0x28, 1, 0)
    rig.bench.clock.sleep_s(0.001)
    assert rig.ask(0x2D, 16) == data
    assert int.from_bytes(rig.ask(0x10, 8, 0, 1), "little") == (0 if ticks is None else 96_000 // ticks)


# Counters


@pytest.mark.parametrize(("bits", "ticks"), [(0, 2400), (1, 240), (2, 24), (3, 2)])
def test_a_period_is_measured_in_ticks_of_four_sizes(bits: int, ticks: int) -> None:
    """Row 0x11, b5:4: 50 us in ticks of 20.83, 208.3, 2083.3 and 20833.3 ns; the last gives 2.4."""
    rig = Rig(sync_counter=1)
    rig.scan([1], scans=4)
    rig.out(0x11, 0x01 | bits << 4, 1)
    rig.show(3)
    assert rig.read_words(4)[1:] == [ticks] * 3


def test_a_counter_that_counts_down_passes_zero_to_the_largest_number_of_64_bits() -> None:
    """Row 0x12, b2. From 2, five pulses lead to -3."""
    rig = Rig(timer_wires=[{"timer": 0, "counter": 1}])
    rig.out(0x18, 0, 1, bytes([0, 0x04, 0, 0, 16]))
    rig.out(0x10, 0, 1, (2).to_bytes(8, "little"))
    rig.out(0x2D, 0, 0, _words(95, 9, 5, 0))
    rig.out(0x28, 1)
    rig.bench.clock.sleep_s(0.01)
    assert _count(rig, 1) == 2**64 - 3


def test_clear_on_read_gives_what_came_since_the_last_read() -> None:
    """Row 0x12, b0: seven pulses, then none."""
    rig = Rig(timer_wires=[{"timer": 0, "counter": 1}])
    rig.out(0x18, 0, 1, bytes([0, 0x01, 0, 0, 16]))
    rig.out(0x2D, 0, 0, _words(95, 9, 7, 0))
    rig.out(0x28, 1)
    rig.bench.clock.sleep_s(0.01)
    assert [_count(rig, 1), _count(rig, 1)] == [7, 0]


@settings(max_examples=30, deadline=None)
@given(value=st.integers(0, 2**64 - 1), options=st.sampled_from([0x00, 0x04]))
def test_a_count_that_was_set_is_read_back(value: int, options: int) -> None:
    """Row 0x10, up and down."""
    rig = Rig()
    rig.out(0x12, options, 3)
    rig.out(0x10, 0, 3, value.to_bytes(8, "little"))
    assert _count(rig, 3) == value


# Memory and lines


def test_user_memory_ends_at_0x7fff() -> None:
    """Row 0x30: 4096 bytes from 0x7000 on; a byte beyond is refused, and so is the last one of the firmware."""
    rig = Rig()
    for address, data, refused in (
        (0x7FFF, b"a", False),
        (0x7FFE, b"bcd", True),
        (0x6FFF, b"e", True),
        (0x7000, b"f", False),
    ):
        rig.out(0x31, 0, 0, address.to_bytes(2, "little"))
        if refused:
            assert errno_of(rig.out, 0x30, 0, 0, data) == STALL
        else:
            rig.out(0x30, 0, 0, data)
    rig.out(0x31, 0, 0, (0x7FFE).to_bytes(2, "little"))
    assert rig.ask(0x30, 64) == b"\0a"
    rig.out(0x31, 0, 0, (0x6FFF).to_bytes(2, "little"))
    assert rig.ask(0x30, 2) == b"\0f"


def test_only_0xad_unlocks_the_firmware_and_anything_else_locks_it_again() -> None:
    """Row 0x32."""
    rig = Rig()
    for key, refused in ((b"\xac", True), (b"\xad", False), (b"\x00", True)):
        rig.out(0x32, 0, 0, key)
        rig.out(0x31, 0, 0, b"\x00\x10")
        if refused:
            assert errno_of(rig.out, 0x30, 0, 0, b"x") == STALL
        else:
            rig.out(0x30, 0, 0, b"x")


def test_an_output_shows_its_latch_and_an_input_does_not() -> None:
    """Rows 0x00 to 0x02: 1 is an input."""
    rig = Rig()
    rig.out(0x00, 0xFF)
    rig.out(0x02, 0xFF)
    assert rig.ask(0x01, 2) == b"\0\0"
    rig.out(0x00, 0xFE)
    assert rig.ask(0x01, 2) == b"\x01\0"


def test_a_serial_number_has_eight_characters() -> None:
    """Row 0x48."""
    rig = Rig()
    rig.out(0x48, 0, 0, b"01ABCDEF")
    assert rig.ask(0x48, 8) == b"01ABCDEF"
    assert errno_of(rig.out, 0x48, 0, 0, b"01ABCDE") == STALL


def test_limits_and_output_values_have_two_registers_each() -> None:
    """Rows 0x16 and 0x17: value 0 or 1, and 0 is the lower limit, 1 the upper one."""
    rig = Rig()
    rig.out(0x17, 1, 0, b"\xff" * 8)
    rig.out(0x16, 1, 0, b"\x07" * 8)
    rig.out(0x17, 0, 0, (5).to_bytes(8, "little"))
    rig.out(0x16, 0, 0, (6).to_bytes(8, "little"))
    assert [rig.ask(0x17, 8, which, 0)[0] for which in (0, 1)] == [5, 255]
    assert [rig.ask(0x16, 8, which, 0)[0] for which in (0, 1)] == [6, 7]
