"""The thin layer over libusb, on a bus of a few lines that behaves as the package ``usb1`` says that it does."""

# ruff: noqa: FBT001, FBT002, N802, PLR0917  (names and arguments are usb1's)

import errno
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from drivers.usb_ctr.image import maker_image
from drivers.usb_ctr.pipe import UsbFault, UsbPipe, find_pipes
from drivers.usb_ctr.plugin import availability, open_counter, probe, run_self_test
from drivers.usb_ctr.settings import UsbCtrSettings
from protocols import BenchContext, CounterRun, DeviceBusy, DeviceRefused, DeviceTimeout, DriverUnavailable, InputError
from tests.drivers.h10682.clock import ScriptClock

usb1: Any = import_module("usb1")
CANCELLED: int = usb1.TRANSFER_CANCELLED


@dataclass
class Bus:
    """A ``usb1.USBContext`` with boards of these serial numbers; it remembers what each was told."""

    serials: list[bytes]
    packets: list[bytes | int] = field(default_factory=list[bytes | int])
    """Packets that have come, and statuses with which a transfer ends instead."""
    status: bytes = b"\x00\x01"
    transfers: list[str] = field(default_factory=list[str])
    error: BaseException | None = None
    closed: int = 0
    held: bool = False
    """Whether another program has the interface."""
    queue: list["Transfer"] = field(default_factory=list["Transfer"])
    most_queued: int = 0
    waited_s: float = 0.0

    def getDeviceIterator(self, skip_on_error: bool = False) -> Iterator["Board"]:
        assert skip_on_error
        return iter([Board(self, serial) for serial in self.serials])

    def handleEventsTimeout(self, tv: float) -> None:
        """One packet for each call, as a slow bus would; cancellations come behind it."""
        if self.queue and self.packets:
            packet = self.packets.pop(0)
            self.queue[0].end(packet if isinstance(packet, bytes) else b"", packet if isinstance(packet, int) else 0)
        else:
            self.waited_s += tv
        for transfer in [transfer for transfer in self.queue if transfer.cancelled]:
            transfer.end(b"", CANCELLED)


@dataclass
class Board:
    """``USBDevice`` and ``USBDeviceHandle`` in one."""

    bus: Bus
    serial: bytes
    claimed: bool = False

    def getVendorID(self) -> int:
        return 0x09DB

    def getProductID(self) -> int:
        return 0x0127

    def open(self) -> "Board":
        return self

    def close(self) -> None:
        assert not self.bus.queue
        self.bus.closed += 1

    def getConfiguration(self) -> int:
        return 0

    def setConfiguration(self, configuration: int) -> None:
        assert configuration == 1

    def claimInterface(self, interface: int) -> None:
        assert interface == 0
        if self.bus.held:
            raise usb1.USBErrorBusy
        self.claimed = True

    def clearHalt(self, endpoint: int) -> None:
        if not self.claimed:
            raise usb1.USBErrorNotFound
        self.bus.transfers.append(f"clear {endpoint:02x}")

    def getTransfer(self) -> "Transfer":
        return Transfer(self)

    def controlWrite(self, kind: int, request: int, value: int, index: int, data: bytes, timeout: int) -> int:
        assert (kind, timeout) == (0x40, 1000)
        self._fail()
        self.bus.transfers.append(f"{request:02x} {value} {index} {data.hex()}".strip())
        return len(data)

    def controlRead(self, kind: int, request: int, _value: int, _index: int, length: int, timeout: int) -> bytearray:
        assert (kind, timeout) == (0x40, 1000)
        self._fail()
        return bytearray({0x40: self.bus.status, 0x48: self.serial, 0x52: b"\x02\x01"}[request][:length])

    def _fail(self) -> None:
        if self.bus.error is not None:
            raise self.bus.error


@dataclass(eq=False)
class Transfer:
    """A ``USBTransfer``."""

    board: Board
    callback: Callable[["Transfer"], None] | None = None
    data: bytes = b""
    status: int = 0
    cancelled: bool = False
    closed: bool = False

    def setBulk(self, endpoint: int, length: int, callback: Callable[["Transfer"], None]) -> None:
        assert (endpoint, length) == (0x86, 512)
        self.callback = callback

    def submit(self) -> None:
        assert self.board.claimed
        assert not self.isSubmitted()
        self.board.bus.queue.append(self)
        self.board.bus.most_queued = max(self.board.bus.most_queued, len(self.board.bus.queue))

    def cancel(self) -> None:
        self.cancelled = True

    def isSubmitted(self) -> bool:
        return self in self.board.bus.queue

    def getStatus(self) -> int:
        return self.status

    def getActualLength(self) -> int:
        return len(self.data)

    def getBuffer(self) -> bytearray:
        return bytearray(self.data.ljust(512, b"?"))

    def close(self) -> None:
        assert not self.isSubmitted()
        self.closed = True

    def end(self, data: bytes, status: int) -> None:
        self.board.bus.queue.remove(self)
        self.data, self.status = data, status
        assert self.callback is not None
        self.callback(self)


def only(bus: Bus) -> UsbPipe:
    (pipe,) = find_pipes(bus)
    return pipe


def reading(bus: Bus) -> UsbPipe:
    pipe = only(bus)
    pipe.claim()
    pipe.begin_packets()
    return pipe


def test_control_transfers_are_vendor_requests_to_the_device() -> None:
    bus = Bus([b"01234567"])
    pipe = only(bus)
    assert pipe.ask(0x48, 0, 0, 8) == b"01234567"
    pipe.tell(0x24, 5, 0, b"")
    pipe.claim()
    pipe.clear_halt()
    assert bus.transfers == ["24 5 0", "clear 86"]


def test_32_transfers_wait_for_packets_and_each_that_has_brought_one_waits_again() -> None:
    """As many as the maker's library has in flight. A transfer that ends empty is no packet."""
    bus = Bus([b"01234567"], [b"\x05\x00", b"", b"\x06\x00\x07\x00"])
    pipe = reading(bus)
    assert len(bus.queue) == 32
    assert [pipe.packet() for _ in range(4)] == [b"\x05\x00", b"", b"\x06\x00\x07\x00", b""]
    assert bus.waited_s == pytest.approx(1e-3)  # for the last, which had not come
    assert (len(bus.queue), bus.most_queued) == (32, 32)


def test_the_end_of_reading_cancels_what_waits_and_forgets_what_nobody_took() -> None:
    bus = Bus([b"01234567"], [b"\x05\x00"])
    pipe = reading(bus)
    waiting = list(bus.queue)
    pipe.end_packets()
    assert bus.queue == []
    assert all(transfer.closed for transfer in waiting)
    assert pipe.packet() == b""
    bus.packets.append(b"\x06\x00")
    pipe.begin_packets()
    assert pipe.packet() == b"\x06\x00"
    pipe.close()
    pipe.close()
    assert (bus.queue, bus.closed) == ([], 1)


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("IO", errno.EIO), ("InvalidParam", errno.EINVAL), ("Access", errno.EACCES), ("NoDevice", errno.ENODEV),
        ("NotFound", errno.ENOENT), ("Busy", errno.EBUSY), ("Timeout", errno.ETIMEDOUT), ("Overflow", errno.EOVERFLOW),
        ("Pipe", errno.EPIPE), ("Interrupted", errno.EINTR), ("NoMem", errno.ENOMEM), ("NotSupported", errno.ENOTSUP),
        ("Other", errno.EIO),
    ],
)  # fmt: skip
def test_libusb_s_errors_have_the_numbers_of_the_operating_system(name: str, number: int) -> None:
    error: BaseException = getattr(usb1, f"USBError{name}")()
    with pytest.raises(UsbFault, match="LIBUSB_ERROR") as raised:
        only(Bus([b"01234567"], error=error)).ask(0x40, 0, 0, 2)
    assert raised.value.errno == number


@pytest.mark.parametrize(
    ("status", "number"),
    [
        (usb1.TRANSFER_NO_DEVICE, errno.ENODEV),
        (usb1.TRANSFER_STALL, errno.EPIPE),
        (usb1.TRANSFER_OVERFLOW, errno.EOVERFLOW),
        (usb1.TRANSFER_ERROR, errno.EIO),
        (usb1.TRANSFER_TIMED_OUT, errno.ETIMEDOUT),
        (usb1.TRANSFER_CANCELLED, errno.EIO),
    ],
)
def test_a_transfer_that_fails_is_a_fault_behind_the_packets_before_it(status: int, number: int) -> None:
    pipe = reading(Bus([b"01234567"], [b"\x05\x00", status, b"\x06\x00"]))
    assert pipe.packet() == b"\x05\x00"
    for _ in range(2):
        with pytest.raises(UsbFault) as raised:
            pipe.packet()
        assert raised.value.errno == number


def test_a_transfer_that_cannot_be_queued_again_is_a_fault_behind_its_packet(monkeypatch: pytest.MonkeyPatch) -> None:
    pipe = reading(Bus([b"01234567"], [b"\x05\x00"]))

    def gone(_transfer: Transfer) -> None:
        raise usb1.USBErrorNoDevice

    monkeypatch.setattr(Transfer, "submit", gone)
    assert pipe.packet() == b"\x05\x00"
    with pytest.raises(UsbFault, match="NO_DEVICE"):
        pipe.packet()


def test_a_whole_run_through_the_pipe() -> None:
    bus = Bus([b"01234567"], [b"\x09\x00", b"\x05\x00", b"\x06\x00"])
    with open_counter(UsbCtrSettings(), BenchContext(clock=ScriptClock(), transport=bus)) as counter:
        assert counter.identity.simulated
        assert counter.identity.model == "USB-CTR08 with H10682-210"
        counter.arm(CounterRun(n_bins=2, period_s=50e-6))
        assert counter.read(1.0).counts.tolist() == [5, 6]
        assert counter.disarm().edges_seen == 3
    assert bus.transfers[-3:] == ["22 0 0", "23 0 0", "24 5 0"]
    assert bus.closed == 1


def test_the_interface_is_claimed_at_opening_so_that_a_halt_can_be_cleared_everywhere() -> None:
    """Libusb on Windows and macOS finds no endpoint on an interface that nobody has claimed."""
    bus = Bus([b"01234567"])
    with pytest.raises(UsbFault, match="NOT_FOUND"):
        only(bus).clear_halt()
    with open_counter(UsbCtrSettings(), BenchContext(clock=ScriptClock(), transport=bus)) as counter:
        counter.arm(CounterRun(n_bins=2, period_s=50e-6))


def test_a_board_that_another_program_holds_is_refused_at_opening_and_its_neighbour_is_not() -> None:
    with pytest.raises(DeviceBusy, match=r"EBUSY.*claiming the board.*other program"):
        open_counter(UsbCtrSettings(), BenchContext(transport=Bus([b"01234567"], held=True)))


def test_the_maker_s_driver_on_the_board_is_told_with_the_way_to_change_it() -> None:
    bus = Bus([b"01234567"], error=usb1.USBErrorNotSupported())
    with pytest.raises(DriverUnavailable, match=r"maker's driver holds the board.*Zadig.*InstaCal"):
        open_counter(UsbCtrSettings(), BenchContext(transport=bus))


def test_the_self_test_opens_the_board_by_itself_and_closes_it_again() -> None:
    bus = Bus([b"01234567"], [(960).to_bytes(2, "little")] * 300)
    found = run_self_test(UsbCtrSettings(), BenchContext(clock=ScriptClock(), transport=bus), timer=2)
    assert found.codes_that_count == (16, 0)
    assert bus.transfers[-1] == "28 0 2"
    assert bus.closed == 1
    bus.packets.clear()
    with pytest.raises(DeviceTimeout, match="0 samples"):
        run_self_test(UsbCtrSettings(), BenchContext(clock=ScriptClock(), transport=bus))
    assert bus.closed == 2


def test_one_of_two_boards_is_chosen_by_its_serial_number_and_the_other_closed() -> None:
    bus = Bus([b"00000001", b"00000002"])
    context = BenchContext(clock=ScriptClock(), transport=bus)
    with pytest.raises(DriverUnavailable, match=r"USB-CTR08 00000001, USB-CTR08 00000002.*set serial"):
        open_counter(UsbCtrSettings(), context)
    assert bus.closed == 2
    with open_counter(UsbCtrSettings(serial="00000002"), context) as counter:
        assert counter.identity.serial == "00000002"
        assert bus.closed == 3
    with pytest.raises(DriverUnavailable, match="with serial number 3"):
        open_counter(UsbCtrSettings(serial="3"), context)


def test_no_board_and_no_right_to_use_it_are_told_apart() -> None:
    with pytest.raises(DriverUnavailable, match="saw boards none"):
        open_counter(UsbCtrSettings(), BenchContext(transport=Bus([])))
    denied = Bus([b"01234567"], error=usb1.USBErrorAccess())
    with pytest.raises(DriverUnavailable, match="udev rule for vendor 09db"):
        open_counter(UsbCtrSettings(), BenchContext(transport=denied))


def test_the_fpga_image_is_looked_for_beside_bench_toml_and_the_board_closed_without_it(tmp_path: Path) -> None:
    bus = Bus([b"01234567"], status=b"\x00\x00")
    context = BenchContext(transport=bus, folder=tmp_path)
    with pytest.raises(InputError, match="No such file"):
        open_counter(UsbCtrSettings(fpga_image=Path("usb-ctr.rbf")), context)
    assert bus.closed == 1


def test_a_transport_that_is_not_a_usb_bus_is_refused() -> None:
    with pytest.raises(InputError, match="a transport of type str"):
        open_counter(UsbCtrSettings(), BenchContext(transport="COM3"))


def test_without_libusb_the_driver_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_library(_context: object) -> None:
        raise FileNotFoundError("cannot find a suitable libusb-1.0")

    monkeypatch.setattr(usb1.USBContext, "open", no_library)
    told = availability()
    assert not told.ready
    assert "no libusb library on this machine. To do: install libusb 1.0" in told.missing
    assert probe() == ()
    with pytest.raises(DriverUnavailable, match="libusb"):
        open_counter(UsbCtrSettings(), BenchContext())


def test_the_driver_is_ready_only_with_the_maker_s_image(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("drivers.usb_ctr.plugin.find_pipes", lambda: find_pipes(Bus([])))
    for user in ("plugin", "board"):
        monkeypatch.setattr(f"drivers.usb_ctr.{user}.maker_image", lambda: maker_image(tmp_path))
    told = availability()
    assert not told.ready
    assert "FPGA image" in told.missing
    assert "To do: set fpga_image" in told.missing
    (tmp_path / "USB_1808.rbf").write_bytes(b"\0")
    assert not availability().ready
    (tmp_path / "USB_CTR.rbf").write_bytes(bytes(100))
    assert availability().ready
    bus = Bus([b"01234567"], status=b"\x00\x00")
    with pytest.raises(DeviceRefused, match=r"not configured after USB_CTR.rbf"):
        open_counter(UsbCtrSettings(), BenchContext(transport=bus))
    assert bus.transfers[0] == "50 0 0 ad"


def test_probing_names_boards_and_what_keeps_one_from_answering(monkeypatch: pytest.MonkeyPatch) -> None:
    bus = Bus([b"01234567"])
    monkeypatch.setattr("drivers.usb_ctr.plugin.find_pipes", lambda: find_pipes(bus))
    assert probe() == ("USB-CTR08 01234567",)
    bus.error = usb1.USBErrorAccess()
    assert "ERROR_ACCESS" in probe()[0]
