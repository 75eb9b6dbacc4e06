"""Scans on the external clock: words, packets, status, and the counts of the bench to the bit (5.1, 5.2)."""

from itertools import chain

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from protocols import BenchContext, CounterRun, InputError
from sim_backends.devices.counter import CounterSettings, open_counter
from sim_backends.wire.usb_ctr import UsbCtrEmulatorSettings, plugin
from tests.sim_backends.projector import PICTURE_S, bench_with
from tests.sim_backends.wire.usb_ctr.rig import NO_DEVICE, OVERFLOW, PHOTONS, STALL, TIMEOUT, Rig, errno_of


def test_a_scan_of_600_patterns_gives_the_counts_of_the_bench() -> None:
    """SINGLEIO: each read is one scan. Scan 0 spans from the start to the first edge and is no data."""
    rig = Rig()
    rig.scan(scans=601)
    assert rig.status() == 0x0102
    rig.show(600)
    words = rig.read_words(601)
    assert words == [3, *rig.bins(600)]
    assert rig.bench.clock.now_s() == pytest.approx(0.001 + 600 * PICTURE_S)
    assert rig.status() == 0x0120
    assert errno_of(rig.read) == TIMEOUT


@pytest.mark.parametrize("mask", [0x20, 0x40])
def test_the_bit_of_a_scan_that_is_done_is_disputed(mask: int) -> None:
    rig = Rig(scan_done_mask=mask)
    rig.scan(scans=1)
    rig.show(1)
    rig.read()
    assert rig.status() == 0x0100 | mask


def test_blocks_never_deliver_the_last_partial_packet_of_a_scan_that_is_cut_short() -> None:
    """256 words a packet, 300 edges of 400: one packet, then nothing; stopping changes nothing."""
    rig = Rig()
    rig.scan(scans=400, packet_words=256)
    rig.show(299)
    assert rig.read() == [3, *rig.bins(255)]
    assert errno_of(rig.read) == TIMEOUT
    rig.out(0x22)
    assert errno_of(rig.read) == TIMEOUT
    assert rig.status() == 0x0100


def test_a_complete_scan_flushes_its_last_partial_packet() -> None:
    rig = Rig()
    rig.scan(scans=300, packet_words=256)
    rig.show(299)
    assert rig.read() + rig.read() == [3, *rig.bins(299)]
    withheld = Rig(flush_at_end=False)
    withheld.scan(scans=300, packet_words=256)
    withheld.show(299)
    withheld.read()
    assert errno_of(withheld.read) == TIMEOUT


@pytest.mark.parametrize(("rule", "ends"), [("full-packet", True), ("total", True), ("never", False)])
def test_a_scan_of_whole_packets_ends_with_an_empty_one(rule: str, ends: object) -> None:
    rig = Rig(zero_length_packet=rule)
    rig.scan(scans=512, packet_words=256)
    rig.show(511)
    assert rig.read(1024) == [3, *rig.bins(511)]
    if ends:
        assert rig.read() == []
    assert errno_of(rig.read) == TIMEOUT


def test_a_long_transfer_gives_what_came_before_its_time_was_over() -> None:
    """libusb: data that came is no error."""
    rig = Rig()
    rig.scan(packet_words=256)
    rig.show(299)
    assert len(rig.read(4096, timeout_ms=50)) == 256
    assert rig.bench.clock.now_s() == pytest.approx(0.05)


def test_a_full_speed_bus_has_packets_of_64_bytes() -> None:
    rig = Rig(high_speed=False)
    rig.scan(scans=256, packet_words=256)
    rig.show(255)
    words = [rig.read(64) for _ in range(8)]
    assert [len(packet) for packet in words] == [32] * 8
    assert [*chain(*words)] == [3, *rig.bins(255)]


def test_a_packet_that_does_not_fit_overflows() -> None:
    rig = Rig()
    rig.scan(packet_words=4)
    rig.show(10)
    assert errno_of(rig.read, 4) == OVERFLOW


def test_without_clear_on_read_the_counts_add_up_and_wrap_at_16_bits() -> None:
    rig = Rig(scene={"noise": PHOTONS | {"peak_counts": 30_000.0}})
    rig.scan(scans=6)
    rig.out(0x12, 0, 0)
    rig.show(5)
    expected = np.cumsum([3, *rig.bins(5)])
    assert expected[-1] > 65536
    assert rig.read_words(6) == (expected % 65536).tolist()


def test_two_banks_of_a_counter_are_latched_together() -> None:
    """Elements 0x00 and 0x08: bits 15:0 and 31:16."""
    rig = Rig(scene={"noise": PHOTONS | {"peak_counts": 300_000.0}})
    rig.scan([0x00, 0x08], scans=6, packet_words=2)
    rig.show(5)
    words = np.array(rig.read_words(12)).reshape(6, 2)
    assert (words[:, 0] + 65536 * words[:, 1]).tolist() == [3, *rig.bins(5)]
    assert words[:, 1].max() > 0


def test_a_counter_that_was_set_and_is_kept_goes_on_in_64_bits() -> None:
    """Option b0 of SCAN_START keeps the counters; all four banks."""
    rig = Rig()
    rig.out(0x13, 16, 0)
    rig.out(0x10, 0, 0, (2**64 - 2).to_bytes(8, "little"))
    rig.out(0x20, 0, 3, bytes([0x00, 0x08, 0x10, 0x18]).ljust(33, b"\0"))
    rig.out(0x21, 0, 0, (1).to_bytes(4, "little") + bytes(8) + b"\x03\x01")
    rig.show(1)
    assert rig.read_words(4) == [1, 0, 0, 0]


def test_counting_down_is_an_option() -> None:
    rig = Rig()
    rig.scan(scans=2)
    rig.out(0x12, 0x04, 0)
    rig.show(1)
    assert rig.read_words(2) == [65533, 65533 - rig.bins(1)[0]]


def test_a_photon_line_with_debounce_loses_every_photon() -> None:
    """The register at power-up is 0, which the maker's table makes 500 ns."""
    rig = Rig()
    rig.scan(scans=6)
    rig.out(0x13, 0, 0)
    rig.show(5)
    assert rig.read_words(6) == [0] * 6


def test_a_counter_that_is_not_wired_counts_nothing_and_a_wired_sync_counts_edges() -> None:
    rig = Rig(sync_counter=2)
    rig.scan([0, 1, 2], scans=4, packet_words=3)
    rig.show(3)
    bins = rig.bins(3)
    assert rig.read_words(12) == [3, 0, 1, bins[0], 0, 1, bins[1], 0, 1, bins[2], 0, 1]


def test_the_sync_input_can_measure_its_period() -> None:
    """Mode 1, tick 20.83 ns: 50 us are 2,400 ticks."""
    rig = Rig(sync_counter=1)
    rig.scan([1], scans=4)
    rig.out(0x11, 0x01, 1)
    rig.show(3)
    assert rig.read_words(4)[1:] == [2400, 2400, 2400]


@pytest.mark.parametrize(("works", "third"), [(False, 3), (True, 0)])
def test_bit_6_of_an_element_is_ignored_but_bit_5_gives_zero(works: object, third: int) -> None:
    rig = Rig(zero_fill_works=works)
    rig.out(0x18, 0, 0, bytes([0, 0, 0, 0, 16]))
    rig.out(0x20, 0, 2, bytes([0x00, 0x21, 0x40]).ljust(33, b"\0"))
    rig.out(0x21, 0, 0, (1).to_bytes(4, "little") + bytes(8) + b"\x02\x00")
    rig.show(1)
    assert rig.read_words(3) == [3, 0, third]


def test_counters_may_be_read_as_soon_as_scanning_starts() -> None:
    rig = Rig(reads_at_start=True)
    rig.scan(scans=7)
    assert rig.read() == [0]
    rig.show(5)
    assert rig.read_words(6) == [3, *rig.bins(5)]


def test_a_scan_on_the_internal_pacer_adds_up_to_the_same_light() -> None:
    """96 MHz / 9600: a scan each 100 us, two pictures. Scan 0 is taken at the start and holds nothing."""
    rig = Rig()
    rig.scan(scans=40, pacer=9599)
    rig.show(50)
    words = rig.read_words(40)
    assert words[0] == 0
    assert sum(words) == 3 + sum(rig.bins(50))
    assert rig.bench.clock.now_s() == pytest.approx(0.0039)


def test_only_packets_of_256_words_bring_the_rest_of_a_complete_scan() -> None:
    """Whole scans in a packet were seen not to work (wjasper/Linux_Drivers #35): 300 = 1 x 256 + 44 = 4 x 64 + 44."""
    rig = Rig()
    rig.scan(scans=300, packet_words=64)
    rig.show(299)
    assert rig.read_words(256) == [3, *rig.bins(255)]
    assert errno_of(rig.read) == TIMEOUT
    assert rig.status() == 0x0120


def test_scanning_twice_configuring_while_scanning_and_scanning_nothing_stall() -> None:
    rig = Rig()
    assert errno_of(rig.out, 0x21, 0, 0, bytes(14)) == STALL
    rig.scan()
    assert errno_of(rig.out, 0x21, 0, 0, bytes(14)) == STALL
    assert errno_of(rig.out, 0x20, 0, 0, bytes(33)) == STALL
    rig.out(0x22)
    rig.out(0x20, 0, 0, bytes(33))


def test_the_fifo_is_cleared_and_the_pipe_flushed() -> None:
    """The other driver's end: SCAN_STOP, SCAN_CLEAR_FIFO, BULK_FLUSH 5."""
    rig = Rig()
    rig.scan()
    rig.show(10)
    rig.bench.clock.sleep_s(0.1)
    rig.out(0x22)
    rig.out(0x24, 5)
    assert rig.read() == [rig.bins(5)[4]]
    rig.out(0x23)
    assert errno_of(rig.read) == TIMEOUT


def test_a_device_can_scan_again_and_again() -> None:
    rig = Rig()
    for _ in range(3):
        rig.scan(scans=6)
        rig.show(5)
        assert rig.read_words(6) == [3, *rig.bins(5)]


def test_a_host_that_does_not_read_overruns_the_fifo_and_keeps_what_was_in_it() -> None:
    """8 bytes hold four scans; the fifth is one too many."""
    rig = Rig(fifo_bytes=8)
    rig.scan()
    rig.show(10)
    rig.bench.clock.sleep_s(0.1)
    assert rig.status() == 0x0104
    assert rig.read_words(4) == [3, *rig.bins(3)]


def test_edges_too_fast_for_the_pacer_overrun_it() -> None:
    """Two words at 4 MS/s: 500 ns."""
    rig = Rig(scene={"faults": [{"kind": "double-edge", "picture": 2, "after_s": 400e-9}]}, pacer_overrun_mask=0x1000)
    rig.scan([0, 8], packet_words=2)
    rig.show(5)
    assert rig.read_words(6) == [3, 0, rig.bins(2)[0], 0, rig.bins(2)[1], 0]
    assert errno_of(rig.read) == TIMEOUT
    assert rig.status() == 0x1100


@pytest.mark.parametrize(("kind", "status"), [("overrun", 0x0104), ("pacer-overrun", 0x0104)])
def test_an_overrun_stops_the_scan_and_leaves_the_words_before_it(kind: str, status: int) -> None:
    rig = Rig(faults=[{"kind": kind, "at": 4}])
    rig.scan()
    rig.show(10)
    assert rig.read_words(4) == [3, *rig.bins(3)]
    assert errno_of(rig.read) == TIMEOUT
    assert rig.status() == status


def test_a_device_that_is_unplugged_is_no_device_any_more() -> None:
    rig = Rig(faults=[{"kind": "disconnect", "at": 4}])
    rig.scan()
    rig.show(10)
    assert rig.read_words(4) == [3, *rig.bins(3)]
    assert errno_of(rig.read) == NO_DEVICE
    assert errno_of(rig.status) == NO_DEVICE
    assert errno_of(rig.out, 0x22) == NO_DEVICE


def test_a_short_packet_is_followed_by_its_rest() -> None:
    rig = Rig(faults=[{"kind": "short-packet", "at": 5}])
    rig.scan(packet_words=8)
    rig.show(15)
    packets = [rig.read(16) for _ in range(3)]
    assert [len(packet) for packet in packets] == [3, 5, 8]
    assert [*chain(*packets)] == [3, *rig.bins(15)]


def test_an_empty_packet_may_come_in_between() -> None:
    rig = Rig(faults=[{"kind": "zero-length-packet", "at": 2}])
    rig.scan()
    rig.show(5)
    packets = [rig.read() for _ in range(7)]
    assert packets == [[3], [rig.bins(1)[0]], [], *([count] for count in rig.bins(5)[1:])]


def test_a_race_of_reading_and_clearing_moves_counts_to_the_neighbour() -> None:
    rig = Rig(faults=[{"kind": "clear-race", "at": 3}, {"kind": "clear-race", "at": 6, "counts": -2}])
    rig.scan()
    rig.show(9)
    off = np.array(rig.read_words(10)[1:]) - np.array(rig.bins(9))
    assert off.tolist() == [0, 0, -1, 1, 0, 2, -2, 0, 0]


def test_missing_and_surplus_edges_are_seen_as_they_are() -> None:
    rig = Rig(scene={"faults": [{"kind": "drop-edge", "picture": 2}, {"kind": "surplus-edges", "edges": 2}]})
    rig.scan()
    rig.show(5)
    assert rig.read_words(7) == [3, *rig.bins(6)]
    assert errno_of(rig.read) == TIMEOUT


def test_a_read_without_limit_ends_when_patience_is_over() -> None:
    rig = Rig(patience_s=60.0)
    rig.scan()
    assert errno_of(rig.read, 512, 0) == TIMEOUT
    assert rig.bench.clock.now_s() == 60.0


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    packet_words=st.sampled_from([1, 2, 6, 50, 256]),
    pauses_ms=st.lists(st.tuples(st.integers(0, 40), st.sampled_from([512, 1024, 4096])), max_size=8),
)
def test_in_whatever_pieces_it_is_read_no_word_is_lost_or_doubled(
    packet_words: int, pauses_ms: list[tuple[int, int]]
) -> None:
    rig = Rig()
    rig.scan(scans=600, packet_words=packet_words)
    rig.show(599)
    words: list[int] = []
    for pause_ms, size in [*pauses_ms, *[(0, 512)] * 600]:
        rig.bench.clock.sleep_s(pause_ms / 1000)
        if len(words) < 600:
            words += rig.read(size)
    assert words == [3, *rig.bins(599)]


def test_a_scene_that_counts_no_photons_is_refused() -> None:
    with pytest.raises(InputError, match=r'choose noise = \{ kind = "poisson" \}'):
        plugin.open(UsbCtrEmulatorSettings(), BenchContext(scene=bench_with(noise={"kind": "pixel"})))


def test_counts_are_those_of_the_simulated_counter() -> None:
    """Same seed, another bench."""
    rig = Rig()
    rig.scan(scans=601)
    rig.show(600)
    words = rig.read_words(601)
    other = Rig()
    counter = open_counter(CounterSettings(), BenchContext(scene=other.bench))
    counter.arm(CounterRun(n_bins=600, period_s=PICTURE_S, latency_s=1.0))
    other.show(600)
    assert words[1:] == counter.read(1.0).counts.tolist()
