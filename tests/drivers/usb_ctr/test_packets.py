"""Full packets of fast runs: how many, when, and what they keep back."""

import pytest

from drivers.usb_ctr.board import UsbCtrBoard
from drivers.usb_ctr.codec import Scan
from drivers.usb_ctr.driver import usb_ctr_counter
from drivers.usb_ctr.packets import Packets, packets_of
from drivers.usb_ctr.settings import EdgeTimer, UsbCtrSettings
from protocols import CounterRun, TimingFault
from tests.drivers.h10682.clock import ScriptClock
from tests.drivers.usb_ctr.script import COUNT, OPEN, START, STOP, WELL, Line, ScriptedPipe

FAST = CounterRun(n_bins=300, period_s=50e-6, latency_s=50e-3)
WIRED = UsbCtrSettings(sync_counter=2)
SYNC: Line = ("18 0 2 0000000010", None)
START_300 = "21 0 0 2d010000" + "00" * 8 + "ff" + "00"
"""301 samples (0x12d) on the external clock, packets of 256 words, counters cleared."""


def first_sample(edges: int = 0) -> list[Line]:
    """The question whether the board samples at the start of a scan: it starts, and has counted no edge."""
    return [*START, count_of(edges), *STOP]


def count_of(edges: int) -> Line:
    return ("10 0 2", edges.to_bytes(8, "little"))


def packet(*counts: int) -> bytes:
    return b"".join(count.to_bytes(2, "little") for count in counts)


@pytest.mark.parametrize(
    ("settings", "period_us", "expected"),
    [
        (UsbCtrSettings(), 50, Packets(words=1, samples=0)),
        (UsbCtrSettings(sync_counter=2), 50, Packets(words=256, samples=301)),
        (UsbCtrSettings(edge_timer=EdgeTimer()), 50, Packets(words=1, samples=0)),
        (UsbCtrSettings(sync_counter=2, first_samples=2), 50, Packets(words=256, samples=302)),
        (UsbCtrSettings(sync_counter=2), 249, Packets(words=256, samples=301)),
        (UsbCtrSettings(sync_counter=2), 251, Packets(words=1, samples=0)),
    ],
)
def test_samples_come_alone_unless_the_run_is_fast_and_its_edges_are_seen_otherwise(
    settings: UsbCtrSettings, period_us: int, expected: Packets
) -> None:
    run = CounterRun(n_bins=319, n_expected=300, period_s=period_us * 1e-6, latency_s=50e-3)
    assert packets_of(run, Scan((0,)), settings) == expected


def test_a_fast_run_comes_in_full_packets_and_the_sync_counter_tells_of_surplus_edges() -> None:
    start = [*START[:4], (START_300, None)]
    script = [*OPEN, COUNT, SYNC, *first_sample(), *start, WELL, count_of(303), *STOP]
    pipe = ScriptedPipe(script, [b"", packet(99, *[7] * 255), packet(*[8] * 45)])
    device = usb_ctr_counter(WIRED, UsbCtrBoard(pipe), ScriptClock())
    device.arm(FAST)
    assert device.read(1.0).counts.tolist() == [7] * 255 + [8] * 45
    report = device.disarm()
    assert (report.bins_closed, report.edges_seen) == (300, 303)
    assert report.notes == ("no edge times: the board does not give them unless edge_timer is wired and set",)
    assert pipe.script == []


def test_a_sample_may_begin_in_one_packet_and_end_in_the_next() -> None:
    """32-bit counts: 3 words of 4 in the first packet. 0x00020001 is 131,073."""
    pipe = ScriptedPipe(
        [
            *OPEN,
            COUNT,
            START[0],
            ("20 0 1 0008" + "00" * 31, None),
            *START[2:4],
            ("21 0 0 " + "00" * 12 + "0100", None),
            WELL,
        ],
        [bytes.fromhex("0300 0000 0100"), bytes.fromhex("0200")],
    )
    device = usb_ctr_counter(UsbCtrSettings(), UsbCtrBoard(pipe), ScriptClock())
    device.arm(CounterRun(n_bins=1, period_s=10e-3))
    assert device.read(1.0).counts.tolist() == [0x20001]


def test_a_lost_edge_leaves_the_last_packet_on_the_board_and_the_report_says_how_much() -> None:
    """300 edges instead of 301: 256 samples came, 44 wait for a packet that is never full."""
    start = [*START[:4], (START_300, None)]
    pipe = ScriptedPipe(
        [*OPEN, COUNT, SYNC, *first_sample(), *start, *[WELL] * 5, count_of(300), *STOP], [b"", packet(99, *[7] * 255)]
    )
    device = usb_ctr_counter(WIRED, UsbCtrBoard(pipe), ScriptClock())
    device.arm(FAST)
    assert device.read(1.0).counts.tolist() == [7] * 255
    assert len(device.read(10e-3)) == 0
    report = device.disarm()
    assert report.edges_seen == 300
    assert report.notes[0].startswith("44 samples stayed on the board")


@pytest.mark.parametrize(
    ("at_start", "first_samples", "edges", "told"),
    [
        (b"", 1, 0, None),
        (packet(0), 2, 0, None),
        (packet(0), 1, 0, "saw 1 samples before any sync edge.*set first_samples = 2"),
        (b"", 2, 0, "saw 0 samples before any sync edge.*set first_samples = 1"),
        (packet(0), 1, 1, None),
    ],
)
def test_whether_the_board_samples_at_its_start_is_found_out_before_a_run_of_full_packets(
    at_start: bytes, first_samples: int, edges: int, told: str | None
) -> None:
    """Such a run ends with its last sample, so a bin too early would not show by the number of edges."""
    samples = 300 + first_samples
    start: list[Line] = [*START[:4], (f"21 0 0 {samples.to_bytes(4, 'little').hex()}" + "00" * 8 + "ff" + "00", None)]
    script = [*OPEN, COUNT, SYNC, *first_sample(edges), *(start if told is None else STOP)]
    pipe = ScriptedPipe(script, [at_start])
    settings = UsbCtrSettings(sync_counter=2, first_samples=first_samples)
    device = usb_ctr_counter(settings, UsbCtrBoard(pipe), ScriptClock())
    if told is None:
        device.arm(FAST)
    else:
        with pytest.raises(TimingFault, match=told):
            device.arm(FAST)
    assert pipe.script == []
