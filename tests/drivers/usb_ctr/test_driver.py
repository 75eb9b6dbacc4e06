"""The USB-CTR driver as its manual page: requests sent, answers given, nothing left over."""

import errno

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.h10682.counter import H10682Counter
from drivers.usb_ctr.board import UsbCtrBoard
from drivers.usb_ctr.driver import usb_ctr_counter
from drivers.usb_ctr.pipe import UsbFault
from drivers.usb_ctr.settings import EdgeTimer, UsbCtrSettings
from protocols import (
    CounterOverrun,
    CounterRun,
    DeviceDisconnected,
    DeviceError,
    DeviceRefused,
    InputError,
    KinopixError,
    PhotonCounter,
    PlanError,
    ProtocolViolation,
    TimingFault,
    WrongState,
)
from tests.drivers.h10682.clock import ScriptClock
from tests.drivers.usb_ctr.script import COUNT, DONE, END, OPEN, OVERRUN, START, STOP, WELL, Line, ScriptedPipe, words

RUN = CounterRun(n_bins=3, period_s=50e-6, latency_s=150e-6)


UNPLUGGED = UsbFault("No such device", errno.ENODEV)


STALL = UsbFault("Pipe error", errno.EPIPE)


def counter(
    script: list[Line], *packets: bytes | UsbFault, settings: UsbCtrSettings | None = None
) -> tuple[H10682Counter, ScriptedPipe]:
    pipe = ScriptedPipe([*OPEN, *script], list(packets))
    return usb_ctr_counter(settings or UsbCtrSettings(), UsbCtrBoard(pipe), ScriptClock()), pipe


def test_a_whole_run_is_these_requests_and_drops_the_sample_of_the_first_edge() -> None:
    device, pipe = counter([COUNT, *START, WELL, *END], *words(99, 5, 0, 7))
    assert isinstance(device, PhotonCounter)
    device.arm(RUN)
    block = device.read(1.0)
    assert block.first_bin == 0
    assert block.counts.tolist() == [5, 0, 7]
    assert block.opening_edge_s is None
    report = device.disarm()
    assert (report.bins_closed, report.edges_seen) == (3, 4)
    assert pipe.script == []
    assert pipe.packets == []


def test_the_identity_has_model_serial_and_fpga_version() -> None:
    device, _ = counter([])
    assert (device.identity.model, device.identity.serial, device.identity.firmware) == (
        "USB-CTR04 with H10682-210",
        "01234567",
        "FPGA 01.02",
    )


def test_surplus_edges_are_counted_and_their_bins_kept_back() -> None:
    device, pipe = counter([COUNT, *START, WELL, *END], *words(99, 5, 0, 7), *words(1, 1))
    device.arm(RUN)
    assert device.read(1.0).counts.tolist() == [5, 0, 7]
    assert len(device.read(1.0)) == 0
    assert device.disarm().edges_seen == 6
    assert pipe.packets == []


def test_a_run_without_an_edge_gives_empty_blocks_and_sees_none() -> None:
    device, _ = counter([COUNT, *START, *[WELL] * 3, *END])
    device.arm(RUN)
    assert len(device.read(300e-6)) == 0
    assert device.disarm().edges_seen == 0


def test_a_board_that_samples_at_its_start_too_has_two_samples_before_the_first_bin() -> None:
    device, _ = counter([COUNT, *START, WELL, *END], *words(0, 99, 5, 0), settings=UsbCtrSettings(first_samples=2))
    device.arm(RUN)
    assert device.read(1.0).counts.tolist() == [5, 0]
    assert device.disarm().edges_seen == 3


TIMED = UsbCtrSettings(edge_timer=EdgeTimer(timer=1, counter=1, period_ticks=9))


TIMED_RUN: list[Line] = [
    COUNT,
    ("18 0 1 0001000010", None),
    ("2d 0 1 09000000" + "00" * 12, None),
    ("28 1 1", None),
    ("22 0 0", None),
    ("20 0 1 0001" + "00" * 31, None),
    ("clear halt 86", None),
    ("23 0 0", None),
    ("21 0 0 " + "00" * 12 + "01" + "00", None),
    WELL,
    WELL,
    *STOP,
    ("28 0 1", None),
]


def test_a_timer_on_a_second_counter_times_the_edges() -> None:
    samples = [bytes.fromhex(s) for s in ("6300 0100", "0500 e001", "0000 c003", "0700 e001")]
    device, pipe = counter(TIMED_RUN, *samples, settings=TIMED)
    device.arm(RUN)
    block = device.read(1.0)
    assert block.counts.tolist() == [5, 0, 7]
    assert block.opening_edge_s is not None
    assert block.opening_edge_s.tolist() == pytest.approx([0.0, 50e-6, 150e-6])
    assert block.closing_edge_s == pytest.approx(200e-6)
    assert device.limits.edge_time_resolution_s == pytest.approx(104.17e-9, rel=1e-4)
    assert device.limits.max_unread_bins == 2048, "8192 words: two counters, of two words each at most"
    assert device.disarm().edges_seen == 4
    assert pipe.script == []


def test_a_timer_that_does_not_tick_is_a_timing_fault_and_no_count_is_lost() -> None:
    """Counts 5 and 8 came, the wire of the timer does not: edges a whole pattern apart without a tick between."""
    samples = [bytes.fromhex(s) for s in ("6300 0100", "0500 0000", "0800 0000")]
    device, pipe = counter(TIMED_RUN, *samples, settings=TIMED)
    device.arm(RUN)
    block = device.read(1.0)
    assert (block.counts.tolist(), block.opening_edge_s) == ([5, 8], None)
    with pytest.raises(TimingFault, match=r"without a tick of the edge timer.*480 ticks a pattern.*wire the timer"):
        device.read(1.0)
    device.disarm()
    assert pipe.script == []


def test_long_bins_are_counted_in_32_bits() -> None:
    start = list(START)
    start[1] = ("20 0 1 0008" + "00" * 31, None)
    start[4] = ("21 0 0 " + "00" * 12 + "01" + "00", None)
    device, _ = counter([COUNT, *start, WELL, *END], *[bytes.fromhex(s) for s in ("0000 0000", "0100 0200")])
    device.arm(CounterRun(n_bins=1, period_s=0.01))
    assert device.read(1.0).counts.tolist() == [0x20001]


def test_an_overrun_comes_after_all_that_was_still_on_the_board() -> None:
    device, _ = counter([COUNT, *START, OVERRUN, OVERRUN, *STOP], *words(99, 5), b"", *words(6))
    device.arm(RUN)
    assert device.read(1.0).counts.tolist() == [5, 6]
    with pytest.raises(CounterOverrun, match=r"status bit 2 \(overrun\) after 3 samples"):
        device.read(1.0)
    report = device.disarm()
    assert report.bins_closed == 2
    assert report.edges_seen is None
    assert "broke off" in report.notes[1]


def test_a_halted_endpoint_is_an_overrun_where_the_status_says_so() -> None:
    device, _ = counter([COUNT, *START, OVERRUN, OVERRUN, *STOP], *words(99, 5), STALL)
    device.arm(RUN)
    assert device.read(1.0).counts.tolist() == [5]
    with pytest.raises(CounterOverrun):
        device.read(1.0)
    device.disarm()


def test_a_scan_that_ends_by_itself_is_a_timing_fault() -> None:
    device, _ = counter([COUNT, *START, DONE, *END])
    device.arm(RUN)
    with pytest.raises(TimingFault, match="status bit 0x20"):
        device.read(1.0)
    device.disarm()


def test_the_other_scan_done_bit_is_a_setting() -> None:
    script: list[Line] = [COUNT, *START, DONE, DONE, *END]
    device, _ = counter(script, settings=UsbCtrSettings(scan_done_mask=0x40))
    device.arm(RUN)
    assert len(device.read(100e-6)) == 0
    device.disarm()


def test_a_board_that_is_pulled_out_gives_its_last_bins_first() -> None:
    gone: Line = ("40 0 0", UNPLUGGED)
    device, _ = counter([COUNT, *START, gone, gone, ("22 0 0", UNPLUGGED)], *words(99, 5), UNPLUGGED)
    device.arm(RUN)
    assert device.read(1.0).counts.tolist() == [5]
    with pytest.raises(DeviceDisconnected, match="USB cable"):
        device.read(1.0)
    report = device.disarm()
    assert report.edges_seen is None
    assert any("while disarming" in note for note in report.notes)


def test_a_torn_packet_is_refused_and_its_whole_samples_are_kept() -> None:
    device, _ = counter([COUNT, *START, WELL, *END], *words(99), bytes.fromhex("0500 06"), *words(7))
    device.arm(RUN)
    assert device.read(1.0).counts.tolist() == [5]
    with pytest.raises(ProtocolViolation, match="a packet of 3 bytes"):
        device.read(1.0)
    device.disarm()


def test_an_arming_that_fails_stops_the_board_and_may_be_tried_again() -> None:
    refused: list[Line] = [COUNT, START[0], (START[1][0], STALL), *STOP]
    device, pipe = counter([*refused, COUNT, *START, *END])
    with pytest.raises(DeviceRefused, match=r"SCAN_CONFIG \(0x20\).*code stall"):
        device.arm(RUN)
    device.arm(RUN)
    device.disarm()
    assert pipe.script == []


def test_the_life_cycle_is_kept() -> None:
    device, pipe = counter([COUNT, *START, *END])
    with device:
        with pytest.raises(WrongState, match="not armed"):
            device.read(1.0)
        assert device.disarm().bins_closed == 0
        device.arm(RUN)
        with pytest.raises(WrongState, match="disarm it first"):
            device.arm(RUN)
    assert pipe.closed
    assert pipe.script == []
    with pytest.raises(WrongState, match="closed"):
        device.arm(RUN)


def test_a_rate_above_single_packet_mode_is_refused_before_a_byte_is_sent() -> None:
    device, _ = counter([])
    with pytest.raises(PlanError, match="at most 100000"):
        device.arm(CounterRun(n_bins=3, period_s=9e-6))


@pytest.mark.parametrize("settings", [UsbCtrSettings(counter=4), UsbCtrSettings(counter=1, edge_timer=EdgeTimer())])
def test_counters_that_the_board_does_not_have_are_refused(settings: UsbCtrSettings) -> None:
    with pytest.raises(InputError, match="from 0 to 3 on a USB-CTR04"):
        counter([], settings=settings)


# --- whatever the bus brings -------------------------------------------------------------------------------------------


class LooseBoard(ScriptedPipe):
    """Answers every status request with ``status`` and takes every other request."""

    status: bytes = b"\x02\x01"

    def ask(self, command: int, value: int, index: int, n_bytes: int) -> bytes:
        return {0x40: self.status, 0x48: b"01234567", 0x52: b"\x02\x01"}[command]

    def tell(self, command: int, value: int, index: int, data: bytes) -> None:
        """Take it."""

    def clear_halt(self) -> None:
        """Do it."""


@given(
    st.lists(st.one_of(st.binary(max_size=6), st.sampled_from([UNPLUGGED, STALL])), max_size=20),
    st.sampled_from([b"\x02\x01", b"\x06\x01", b"\x22\x01"]),
)
def test_whatever_packets_come_the_good_ones_are_handed_over_and_reading_ends(
    packets: list[bytes | UsbFault], status: bytes
) -> None:
    pipe = LooseBoard([], list(packets))
    pipe.status = status
    device = usb_ctr_counter(UsbCtrSettings(), UsbCtrBoard(pipe), ScriptClock())
    device.arm(CounterRun(n_bins=5, period_s=50e-6, latency_s=150e-6))
    got: list[int] = []
    try:
        for _ in range(30):
            block = device.read(300e-6)
            assert block.first_bin == len(got)
            got += block.counts.tolist()
    except KinopixError as error:
        assert isinstance(error, CounterOverrun | TimingFault | ProtocolViolation | DeviceError)  # noqa: PT017
    good = b""
    for packet in packets:
        if isinstance(packet, UsbFault):
            break
        good += packet[: len(packet) // 2 * 2]
        if len(packet) % 2:
            break
    expected = [int.from_bytes(good[at : at + 2], "little") for at in range(2, len(good), 2)][:5]
    assert got == expected[: len(got)]
    assert got == expected or status != b"\x02\x01"
    assert device.disarm().bins_closed == len(got)


@pytest.mark.parametrize(("timer", "unread_bins"), [(None, 4096), (EdgeTimer(), 2048)])
def test_the_board_keeps_8192_words_and_a_bin_has_two_or_four(timer: EdgeTimer | None, unread_bins: int) -> None:
    pipe = ScriptedPipe([*OPEN])
    assert (
        usb_ctr_counter(UsbCtrSettings(edge_timer=timer), UsbCtrBoard(pipe), ScriptClock()).limits.max_unread_bins
        == unread_bins
    )
