"""Control transfers with the literals of the sheet (5.2): what is sent, what is answered."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.sim_backends.wire.usb_ctr.rig import (
    BUSY,
    NO_ACCESS,
    NO_DEVICE,
    NOT_FOUND,
    NOT_SUPPORTED,
    STALL,
    TIMEOUT,
    Rig,
    USBError,
    errno_of,
    find,
)


def test_the_device_is_found_by_its_numbers_and_tells_its_names() -> None:
    for model, product_id in (("USB-CTR04", 0x012E), ("USB-CTR08", 0x0127)):
        rig = Rig(model=model, serial_number="01F00D42")
        handle = find(rig.context, product_id)
        assert [handle.getASCIIStringDescriptor(k) for k in (1, 2, 3)] == ["MCC", model, "01F00D42"]
        handle.setConfiguration(1)
        (device,) = rig.context.getDeviceIterator()
        assert device.getMaxPacketSize(0x86) == 512
        assert rig.ask(0x48, 8) == b"01F00D42"


def test_the_fpga_is_loaded_after_power_up() -> None:
    """0xAD to 0x50, blocks of 64 bytes to 0x51, then bit 8 of the status."""
    rig = Rig(loaded=False, fpga_image_bytes=130)
    assert rig.status() == 0x0000
    rig.out(0x50, 0, 0, b"\xad")
    assert rig.status() == 0x0200
    for block in (bytes(64), bytes(64)):
        rig.out(0x51, 0, 0, block)
    assert rig.status() == 0x0200
    rig.out(0x51, 0, 0, bytes(2))
    assert rig.status() == 0x0100
    assert rig.ask(0x52, 2) == b"\x02\x01"
    assert rig.context.transcript[:3] == [
        (0xC0, 0x40, 0, 0, b"\x00\x00"),
        (0x40, 0x50, 0, 0, b"\xad"),
        (0xC0, 0x40, 0, 0, b"\x00\x02"),
    ]


def test_fpga_data_outside_of_configuration_or_in_large_blocks_stalls() -> None:
    rig = Rig(loaded=False)
    assert errno_of(rig.out, 0x51, 0, 0, bytes(64)) == STALL
    assert errno_of(rig.out, 0x50, 0, 0, b"\xac") == STALL
    rig.out(0x50, 0, 0, b"\xad")
    assert errno_of(rig.out, 0x51, 0, 0, bytes(65)) == STALL


def test_before_the_fpga_is_loaded_counting_is_refused() -> None:
    rig = Rig(loaded=False)
    assert errno_of(rig.out, 0x20, 0, 0, bytes(33)) == STALL
    assert errno_of(rig.ask, 0x10, 8) == STALL


def test_before_the_fpga_is_loaded_counting_may_be_silent_instead() -> None:
    rig = Rig(loaded=False, unconfigured="silent")
    rig.out(0x21, 0, 0, bytes(14))
    assert rig.ask(0x10, 8) == bytes(8)
    assert rig.status() == 0


def test_a_refused_image_leaves_the_fpga_unconfigured() -> None:
    rig = Rig(loaded=False, faults=[{"kind": "fpga-refused"}])
    rig.out(0x50, 0, 0, b"\xad")
    rig.out(0x51, 0, 0, bytes(64))
    assert rig.status() == 0x0200


def test_counter_parameters_are_the_single_registers_in_one() -> None:
    """Mode, options, gate, output, debounce."""
    rig = Rig()
    assert rig.ask(0x18, 5, 0, 2) == b"\0\0\0\0\0"
    rig.out(0x18, 0, 2, b"\x01\x05\x03\x02\x10")
    assert [rig.ask(request, 1, 0, 2) for request in (0x11, 0x12, 0x14, 0x15, 0x13)] == [
        b"\x01", b"\x05", b"\x03", b"\x02", b"\x10",
    ]  # fmt: skip
    rig.out(0x13, 0x21, 2)
    assert rig.ask(0x18, 5, 0, 2) == b"\x01\x05\x03\x02\x21"
    assert rig.ask(0x18, 5, 0, 3) == b"\0\0\0\0\0"


def test_values_of_64_bits_are_kept() -> None:
    rig = Rig()
    value = bytes.fromhex("efcdab8967452301")
    rig.out(0x10, 0, 1, value)
    assert rig.ask(0x10, 8, 0, 1) == value
    for request in (0x16, 0x17):
        rig.out(request, 1, 3, value)
        assert rig.ask(request, 8, 1, 3) == value
    assert rig.ask(0x17, 8, 0, 3) == bytes(8)


@pytest.mark.parametrize(("model", "counters"), [("USB-CTR04", 4), ("USB-CTR08", 8)])
def test_there_are_four_or_eight_counters(model: str, counters: int) -> None:
    rig = Rig(model=model)
    rig.ask(0x10, 8, 0, counters - 1)
    assert errno_of(rig.ask, 0x10, 8, 0, counters) == STALL


def test_a_scan_of_a_counter_that_is_not_there_stalls() -> None:
    assert errno_of(Rig().out, 0x20, 0, 0, b"\x04".ljust(33, b"\0")) == STALL
    Rig(model="USB-CTR08").out(0x20, 0, 0, b"\x04".ljust(33, b"\0"))


def test_digital_lines_latch_and_trigger_are_kept() -> None:
    rig = Rig()
    rig.out(0x00, 0xF0)
    rig.out(0x02, 0x3C)
    assert (rig.ask(0x00, 2), rig.ask(0x02, 2), rig.ask(0x01, 2)) == (b"\xf0\0", b"\x3c\0", b"\x0c\0")
    rig.out(0x43, 0, 0, b"\x03")
    assert rig.ask(0x43, 1) == b"\x03"


def test_user_memory_can_be_written_and_firmware_only_when_unlocked() -> None:
    rig = Rig()
    rig.out(0x31, 0, 0, b"\x10\x70")
    rig.out(0x30, 0, 0, b"rig")
    assert rig.ask(0x31, 2) == b"\x13\x70"
    rig.out(0x31, 0, 0, b"\x10\x70")
    assert rig.ask(0x30, 3) == b"rig"
    rig.out(0x31, 0, 0, b"\x00\x10")
    assert errno_of(rig.out, 0x30, 0, 0, b"x") == STALL
    rig.out(0x32, 0, 0, b"\xad")
    rig.out(0x30, 0, 0, b"x")


def test_after_a_reset_the_device_has_left_the_bus() -> None:
    rig = Rig()
    rig.out(0x42)
    assert errno_of(rig.status) == NO_DEVICE
    assert find(rig.context) is None


@pytest.mark.parametrize(
    ("request_", "data"), [(0x18, bytes(4)), (0x20, bytes(32)), (0x21, bytes(13)), (0x29, bytes(3)), (0x99, b"")]
)
def test_a_request_with_the_wrong_length_or_number_stalls(request_: int, data: bytes) -> None:
    assert errno_of(Rig().out, request_, 0, 0, data) == STALL


def test_a_device_without_permission_or_in_use_cannot_be_opened() -> None:
    assert errno_of(Rig(faults=[{"kind": "no-permission"}]).status) == NO_ACCESS
    assert errno_of(Rig(faults=[{"kind": "interface-claimed"}]).read) == BUSY


def test_one_handle_holds_the_interface() -> None:
    rig = Rig()
    other = find(rig.context)
    assert errno_of(rig.read) == TIMEOUT
    assert errno_of(other.claimInterface, 0) == BUSY
    assert errno_of(other.bulkRead, 0x86, 512, 10) == NOT_FOUND
    rig.handle.close()
    other.claimInterface(0)
    assert errno_of(other.bulkRead, 0x86, 512, 10) == TIMEOUT


def test_a_control_transfer_can_stall_time_out_or_be_late() -> None:
    faults = [
        {"kind": "control", "request": 0x40, "nth": 2},
        {"kind": "control", "request": 0x40, "nth": 3, "error": "timeout"},
        {"kind": "control", "request": 0x40, "nth": 4, "error": "none", "delay_s": 0.5},
    ]
    rig = Rig(faults=faults)
    assert rig.status() == 0x0100
    assert errno_of(rig.status) == STALL
    assert errno_of(rig.status) == TIMEOUT
    assert rig.bench.clock.now_s() == 1.0
    assert rig.status() == 0x0100
    assert rig.bench.clock.now_s() == 1.5


def test_what_the_device_has_not_is_not_found() -> None:
    rig = Rig()
    rig.status()
    assert not rig.handle.kernelDriverActive(0)
    assert errno_of(rig.handle.detachKernelDriver, 0) == NOT_FOUND
    assert errno_of(rig.handle.claimInterface, 1) == NOT_FOUND
    assert errno_of(rig.handle.bulkRead, 0x81, 512, 1) == NOT_FOUND
    assert errno_of(rig.handle.controlRead, 0x00, 0x06, 0x0309, 0, 8) == STALL
    assert errno_of(rig.handle.controlWrite, 0x21, 0x40, 0, 0, b"") == STALL


def test_a_device_that_is_gone_answers_nothing() -> None:
    rig = Rig()
    (device,) = rig.context.getDeviceIterator()
    rig.out(0x42)
    assert errno_of(rig.handle.clearHalt, 0x86) == NO_DEVICE
    assert errno_of(rig.handle.resetDevice) == NO_DEVICE
    assert errno_of(device.open) == NO_DEVICE
    assert errno_of(rig.handle.setConfiguration, 1) == NO_DEVICE


# Timers


def test_a_timer_gives_a_known_pulse_train_to_a_wired_counter() -> None:
    """Period 9599: 10 kHz. Width register 0: 10.4 ns, close to the head's pulse."""
    rig = Rig(timer_wires=[{"timer": 0, "counter": 1}])
    rig.out(0x13, 16, 1)
    rig.out(0x29, 0, 0, (9599).to_bytes(4, "little"))
    assert rig.ask(0x29, 4) == (9599).to_bytes(4, "little")
    rig.out(0x28, 1)
    assert rig.ask(0x28, 1) == b"\x03"
    rig.bench.clock.sleep_s(0.5)
    assert int.from_bytes(rig.ask(0x10, 8, 0, 1), "little") == 5000
    rig.out(0x28, 0)
    rig.bench.clock.sleep_s(0.5)
    assert int.from_bytes(rig.ask(0x10, 8, 0, 1), "little") == 5000


def test_a_timer_can_give_a_number_of_pulses_and_then_stops() -> None:
    rig = Rig(timer_wires=[{"timer": 3, "counter": 1}], debounce_at_power_up=16)
    rig.out(0x2D, 0, 3, b"".join(n.to_bytes(4, "little") for n in (95, 9, 100, 0)))
    rig.out(0x28, 1, 3)
    rig.bench.clock.sleep_s(1.0)
    assert int.from_bytes(rig.ask(0x10, 8, 0, 1), "little") == 100
    assert rig.ask(0x28, 1, 0, 3) == b"\x01"
    assert rig.ask(0x2D, 16, 0, 3)[:8] == b"\x5f\0\0\0\x09\0\0\0"


def test_a_timer_takes_its_period_below_its_old_width_and_gives_no_pulse_until_the_width_is_shorter() -> None:
    """Clients write the period first: 1 kHz with half of it high, then 100 kHz."""
    rig = Rig(timer_wires=[{"timer": 0, "counter": 1}])
    rig.out(0x13, 16, 1)
    for period, width in ((95_999, 47_999), (959, None)):
        rig.out(0x29, 0, 0, period.to_bytes(4, "little"))
        if width is not None:
            rig.out(0x2A, 0, 0, width.to_bytes(4, "little"))
    rig.out(0x28, 1, 0)
    rig.bench.clock.sleep_s(0.01)
    assert int.from_bytes(rig.ask(0x10, 8, 0, 1), "little") == 0
    rig.out(0x2A, 0, 0, (479).to_bytes(4, "little"))
    rig.bench.clock.sleep_s(0.01)
    assert int.from_bytes(rig.ask(0x10, 8, 0, 1), "little") == 1000


def test_timers_work_before_the_fpga_is_loaded_and_counters_do_not() -> None:
    rig = Rig(loaded=False)
    rig.out(0x29, 0, 3, b"\x5f\0\0\0")
    rig.out(0x28, 1, 3)
    assert rig.ask(0x29, 4, 0, 3) == b"\x5f\0\0\0"
    assert errno_of(rig.out, 0x11, 0, 0) == STALL


def test_the_scan_list_reads_back_but_not_while_a_scan_runs() -> None:
    rig = Rig()
    assert rig.ask(0x20, 33) == bytes(33)
    rig.scan([0x00, 0x08])
    assert errno_of(rig.ask, 0x20, 33, 0, 1) == STALL
    rig.out(0x22)
    assert rig.ask(0x20, 33, 0, 1) == b"\x00\x08" + bytes(31)


def test_a_board_may_need_the_two_zero_bytes_behind_its_image() -> None:
    rig = Rig(loaded=False, fpga_needs_zero_bytes=True)
    rig.out(0x50, 0, 0, b"\xad")
    rig.out(0x51, 0, 0, bytes(64))
    assert rig.status() == 0x0200
    rig.out(0x51, 0, 0, b"\0\0")
    assert rig.status() == 0x0100


def test_a_halt_is_cleared_only_on_an_interface_that_is_claimed() -> None:
    """Libusb on Windows and macOS gives NOT_FOUND otherwise."""
    rig = Rig()
    assert errno_of(rig.handle.clearHalt, 0x86) == NOT_FOUND
    rig.handle.claimInterface(0)
    rig.handle.clearHalt(0x86)


def test_the_maker_s_driver_keeps_libusb_from_opening_the_board() -> None:
    assert errno_of(Rig(faults=[{"kind": "maker-driver"}]).status) == NOT_SUPPORTED


@pytest.mark.parametrize(
    ("table", "code", "counted"),
    [("uldaq", 16, True), ("uldaq", 0, False), ("wjasper", 0, True), ("wjasper", 16, False)],
)
def test_the_code_that_switches_the_debounce_off_is_disputed(table: str, code: int, counted: object) -> None:
    """TIMER_PERIOD 9: 9.6 MHz. With the wrong code every pulse is lost."""
    rig = Rig(debounce_table=table, timer_wires=[{"timer": 0, "counter": 1}])
    rig.out(0x13, code, 1)
    rig.out(0x2D, 0, 0, b"".join(n.to_bytes(4, "little") for n in (9, 4, 0, 0)))
    rig.out(0x28, 1)
    rig.bench.clock.sleep_s(0.01)
    assert int.from_bytes(rig.ask(0x10, 8, 0, 1), "little") == (96_000 if counted else 0)


def test_slow_pulses_pass_a_short_debounce() -> None:
    """Code 0 is 500 ns by the maker's table; 1 us high, 1 us low passes."""
    rig = Rig(timer_wires=[{"timer": 0, "counter": 1}])
    rig.out(0x2D, 0, 0, b"".join(n.to_bytes(4, "little") for n in (191, 95, 0, 0)))
    rig.out(0x28, 1)
    rig.bench.clock.sleep_s(0.01)
    assert int.from_bytes(rig.ask(0x10, 8, 0, 1), "little") == 5000


# Robustness


@settings(max_examples=50, deadline=None)
@given(
    requests=st.lists(
        st.tuples(
            st.booleans(), st.integers(0, 255), st.integers(0, 65535), st.integers(0, 40), st.binary(max_size=40)
        ),
        max_size=12,
    )
)
def test_any_control_transfer_is_answered_or_stalls(requests: list[tuple[bool, int, int, int, bytes]]) -> None:
    rig = Rig()
    rig.show(3)
    refusals: list[int] = []
    for inward, number, value, index, data in requests:
        try:
            told = rig.ask(number, len(data), value, index) if inward else b""
            if not inward:
                rig.out(number, value, index, data)
        except USBError as error:
            refusals.append(error.value)
        else:
            assert len(told) <= len(data)
    assert set(refusals) <= {STALL, NO_DEVICE}
