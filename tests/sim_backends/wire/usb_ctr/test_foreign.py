"""Call sequences of a public test program for this family (wjasper/Linux_Drivers, usb-ctr), with the figures of its author.

"Connect Timer 1 to Counter 1": a timer at 100 kHz, a scan of four counters with four banks each on the internal pacer at
1 kHz. Scan 0 is 0, scan 1 is 100, and the counts add up (issue 35 there).
"""

import struct

from tests.sim_backends.wire.usb_ctr.rig import TIMEOUT, Rig, errno_of

LIST = bytes(counter | bank << 3 | 0x40 for counter in range(4) for bank in range(4)).ljust(33, b"\0")
"""Counters 0 to 3, banks 0 to 3, each element with the zero-fill bit, which the FPGA ignores."""


def wired() -> Rig:
    return Rig(timer_wires=[{"timer": 1, "counter": 1}], debounce_table="wjasper")


def set_up_counters(rig: Rig) -> None:
    """Count 0, totalise, rising edge, gate off, output off; each single write has one byte of data."""
    for counter in range(4):
        rig.out(0x10, 0, counter, bytes(8))
        for request in (0x11, 0x12, 0x14, 0x15):
            rig.out(request, 0, counter, b"\0")


def run_timer(rig: Rig, frequency_hz: int) -> None:
    """Period first, then half of it as width, endless, no delay, on: 96 MHz / (period + 1)."""
    ticks = 96_000_000 // frequency_hz
    for request, value in ((0x29, ticks - 1), (0x2A, ticks // 2 - 1), (0x2B, 0), (0x2C, 0)):
        rig.out(request, 0, 1, struct.pack("<I", value))
    rig.out(0x28, 1, 1, b"\0")


def counts_of_counter_1(words: list[int]) -> list[int]:
    scans = [words[at : at + 16] for at in range(0, len(words), 16)]
    return [sum(word << 16 * bank for bank, word in enumerate(scan[4:8])) for scan in scans]


def write_list(rig: Rig) -> None:
    """The program writes the list anew for each element that it adds, and reads it back."""
    for last in range(16):
        rig.out(0x20, 0, last, LIST[: last + 1].ljust(33, b"\0"))
    assert rig.ask(0x20, 33, 0, 15) == LIST


def test_a_scan_of_four_counters_at_1_khz_counts_100_more_each_time() -> None:
    """Key "i": 100 scans in packets of one transfer each of 256 words."""
    rig = wired()
    write_list(rig)
    set_up_counters(rig)
    run_timer(rig, 100_000)
    rig.out(0x21, 0, 0, struct.pack("<IIIBB", 100, 0, 95_999, 255, 0))
    counts = counts_of_counter_1(rig.read_words(1600, timeout_ms=1000))
    assert counts[:3] == [0, 100, 200]
    assert counts == [100 * scan for scan in range(100)]


def test_the_same_after_a_stop_a_clear_and_five_flushes_and_a_second_time() -> None:
    """Key "I", twice in one session: the second scan starts from 0 again (uldaq #40: the first must not be the only one)."""
    rig = wired()
    write_list(rig)
    set_up_counters(rig)
    run_timer(rig, 100_000)
    for _ in range(2):
        rig.out(0x22)
        rig.out(0x23)
        rig.out(0x24, 5)
        rig.out(0x21, 0, 0, struct.pack("<IIIBB", 100, 0, 95_999, 255, 0))
        assert counts_of_counter_1(rig.read_words(1600, timeout_ms=1000)) == [100 * scan for scan in range(100)]
        assert errno_of(rig.read) == TIMEOUT


def test_a_timer_s_frequency_comes_back_as_a_period() -> None:
    """Key "f": counter 1 in period mode x1000 on a timer of 1 kHz; the program prints 1 / (count x 20.83 ns / 1000)."""
    rig = wired()
    run_timer(rig, 1000)
    set_up_counters(rig)
    rig.out(0x11, 0x01 | 0x0C, 1, b"\0")
    rig.bench.clock.sleep_s(2.0)
    count = int.from_bytes(rig.ask(0x10, 8, 0, 1), "little")
    assert round(1 / (count * 20.83e-9 / 1000), 1) == 1000.2


def test_timer_registers_come_back_in_milliseconds_as_they_went_in() -> None:
    """Key "T", before the FPGA is loaded: 1 kHz is 95,999 ticks of 96 MHz beyond the first."""
    rig = Rig(loaded=False)
    for request, value in ((0x29, 95_999), (0x2A, 47_999), (0x2B, 1000), (0x2C, 9600)):
        rig.out(request, 0, 2, struct.pack("<I", value))
    assert [struct.unpack("<I", rig.ask(request, 4, 0, 2))[0] for request in (0x29, 0x2A, 0x2B, 0x2C)] == [
        95_999, 47_999, 1000, 9600,
    ]  # fmt: skip
