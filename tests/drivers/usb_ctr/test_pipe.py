"""The thin layer over ``pyusb``: the real package on a backend of a few lines."""

import errno
from array import array
from collections.abc import Iterator
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

core: Any = import_module("usb.core")


class Descriptor:
    """A USB descriptor: the fields that matter, 0 for the rest."""

    def __init__(self, **fields: int) -> None:
        self.__dict__.update(fields)

    def __getattr__(self, name: str) -> int | None:
        if name.startswith("_"):
            raise AttributeError(name)
        return None if name in {"port_number", "port_numbers", "speed", "bus", "address"} else 0


@dataclass
class Backend:
    """A ``usb.backend.IBackend`` with boards of these serial numbers; it remembers every transfer."""

    serials: list[bytes]
    packets: list[bytes | BaseException] = field(default_factory=list[bytes | BaseException])
    status: bytes = b"\x00\x01"
    transfers: list[str] = field(default_factory=list[str])
    error: BaseException | None = None
    closed: int = 0
    claimed: bool = False
    held: bool = False
    """Whether another program has the interface."""

    def enumerate_devices(self) -> Iterator[int]:
        return iter(range(len(self.serials)))

    def get_parent(self, dev: int) -> None:
        """No hub."""

    def get_device_descriptor(self, dev: int) -> Descriptor:
        return Descriptor(idVendor=0x09DB, idProduct=0x0127, bNumConfigurations=1)

    def get_configuration_descriptor(self, dev: int, config: int) -> Descriptor:
        return Descriptor(bConfigurationValue=1, bNumInterfaces=1)

    def get_interface_descriptor(self, dev: int, intf: int, alt: int, config: int) -> Descriptor:
        if alt:
            raise IndexError
        return Descriptor(bNumEndpoints=1)

    def get_endpoint_descriptor(self, dev: int, ep: int, intf: int, alt: int, config: int) -> Descriptor:
        return Descriptor(bEndpointAddress=0x86, bmAttributes=2, wMaxPacketSize=512)

    def open_device(self, dev: int) -> int:
        return dev

    def close_device(self, handle: int) -> None:
        self.closed += 1

    def set_configuration(self, handle: int, value: int) -> None:
        """Configured."""

    def get_configuration(self, handle: int) -> int:
        return 1

    def claim_interface(self, handle: int, intf: int) -> None:
        if self.held:
            raise core.USBError("Resource busy", -6, errno.EBUSY)
        self.claimed = True

    def release_interface(self, handle: int, intf: int) -> None:
        """Released."""

    def clear_halt(self, handle: int, endpoint: int) -> None:
        if not self.claimed:
            raise core.USBError("Entity not found", -5, errno.ENOENT)
        self.transfers.append(f"clear {endpoint:02x}")

    def bulk_read(self, handle: int, endpoint: int, intf: int, buffer: "array[int]", timeout: int) -> int:
        assert (endpoint, timeout) == (0x86, 1)
        packet = self.packets.pop(0) if self.packets else core.USBTimeoutError("timed out", -7, errno.ETIMEDOUT)
        if isinstance(packet, BaseException):
            raise packet
        buffer[: len(packet)] = array("B", packet)
        return len(packet)

    intr_read = iso_read = bulk_read

    def ctrl_transfer(  # noqa: PLR0917 - pyusb's signature
        self, handle: int, kind: int, request: int, value: int, index: int, data: "array[int]", timeout: int
    ) -> int:
        if self.error is not None:
            raise self.error
        if kind == 0x40:
            self.transfers.append(f"{request:02x} {value} {index} {bytes(data).hex()}".strip())
            return len(data)
        answer = {0x40: self.status, 0x48: self.serials[handle], 0x52: b"\x02\x01"}[request]
        data[: len(answer)] = array("B", answer)
        return len(answer)


def only(backend: Backend) -> UsbPipe:
    (pipe,) = find_pipes(backend)
    return pipe


def test_control_transfers_are_vendor_requests_to_the_device() -> None:
    backend = Backend([b"01234567"])
    pipe = only(backend)
    assert pipe.ask(0x48, 0, 0, 8) == b"01234567"
    pipe.tell(0x24, 5, 0, b"")
    pipe.claim()
    pipe.clear_halt()
    assert backend.transfers == ["24 5 0", "clear 86"]


def test_a_packet_is_what_is_there_and_nothing_is_no_error() -> None:
    pipe = only(Backend([b"01234567"], [b"\x05\x00", b""]))
    assert pipe.packet() == b"\x05\x00"
    assert pipe.packet() == b""
    assert pipe.packet() == b""


def test_another_usb_error_is_a_fault_with_its_number() -> None:
    pipe = only(Backend([b"01234567"], [core.USBError("No such device", -4, errno.ENODEV)]))
    with pytest.raises(UsbFault, match="No such device") as raised:
        pipe.packet()
    assert raised.value.errno == errno.ENODEV


def test_a_whole_run_through_the_real_pyusb_package() -> None:
    backend = Backend([b"01234567"], [b"\x09\x00", b"\x05\x00", b"\x06\x00"])
    with open_counter(UsbCtrSettings(), BenchContext(clock=ScriptClock(), transport=backend)) as counter:
        assert counter.identity.simulated
        assert counter.identity.model == "USB-CTR08 with H10682-210"
        counter.arm(CounterRun(n_bins=2, period_s=50e-6))
        assert counter.read(1.0).counts.tolist() == [5, 6]
        assert counter.disarm().edges_seen == 3
    assert backend.transfers[-3:] == ["22 0 0", "23 0 0", "24 5 0"]
    assert backend.closed == 1


def test_the_interface_is_claimed_at_opening_so_that_a_halt_can_be_cleared_everywhere() -> None:
    """Libusb on Windows and macOS finds no endpoint on an interface that nobody has claimed."""
    backend = Backend([b"01234567"])
    with pytest.raises(UsbFault, match="Entity not found"):
        only(backend).clear_halt()
    with open_counter(UsbCtrSettings(), BenchContext(clock=ScriptClock(), transport=backend)) as counter:
        assert backend.claimed
        counter.arm(CounterRun(n_bins=2, period_s=50e-6))


def test_a_board_that_another_program_holds_is_refused_at_opening_and_its_neighbour_is_not() -> None:
    with pytest.raises(DeviceBusy, match=r"EBUSY.*claiming the board.*other program"):
        open_counter(UsbCtrSettings(), BenchContext(transport=Backend([b"01234567"], held=True)))


def test_the_maker_s_driver_on_the_board_is_told_with_the_way_to_change_it() -> None:
    """Pyusb turns LIBUSB_ERROR_NOT_SUPPORTED into NotImplementedError."""
    backend = Backend(
        [b"01234567"], error=NotImplementedError("Operation not supported or unimplemented on this platform")
    )
    with pytest.raises(DriverUnavailable, match=r"maker's driver holds the board.*Zadig.*InstaCal"):
        open_counter(UsbCtrSettings(), BenchContext(transport=backend))


def test_the_self_test_opens_the_board_by_itself_and_closes_it_again() -> None:
    backend = Backend([b"01234567"], [(960).to_bytes(2, "little")] * 200)
    found = run_self_test(UsbCtrSettings(), BenchContext(clock=ScriptClock(), transport=backend), timer=2)
    assert found.codes_that_count == (16, 0)
    assert backend.transfers[-1] == "28 0 2"
    assert backend.closed == 1
    with pytest.raises(DeviceTimeout, match="0 samples"):
        run_self_test(UsbCtrSettings(), BenchContext(clock=ScriptClock(), transport=backend))
    assert backend.closed == 2


def test_one_of_two_boards_is_chosen_by_its_serial_number_and_the_other_closed() -> None:
    backend = Backend([b"00000001", b"00000002"])
    context = BenchContext(clock=ScriptClock(), transport=backend)
    with pytest.raises(DriverUnavailable, match=r"USB-CTR08 00000001, USB-CTR08 00000002.*set serial"):
        open_counter(UsbCtrSettings(), context)
    assert backend.closed == 2
    with open_counter(UsbCtrSettings(serial="00000002"), context) as counter:
        assert counter.identity.serial == "00000002"
        assert backend.closed == 3
    with pytest.raises(DriverUnavailable, match="with serial number 3"):
        open_counter(UsbCtrSettings(serial="3"), context)


def test_no_board_and_no_right_to_use_it_are_told_apart() -> None:
    with pytest.raises(DriverUnavailable, match="saw boards none"):
        open_counter(UsbCtrSettings(), BenchContext(transport=Backend([])))
    denied = Backend([b"01234567"], error=core.USBError("Access denied", -3, errno.EACCES))
    with pytest.raises(DriverUnavailable, match="udev rule for vendor 09db"):
        open_counter(UsbCtrSettings(), BenchContext(transport=denied))


def test_the_fpga_image_is_looked_for_beside_bench_toml_and_the_board_closed_without_it(tmp_path: Path) -> None:
    backend = Backend([b"01234567"], status=b"\x00\x00")
    context = BenchContext(transport=backend, folder=tmp_path)
    with pytest.raises(InputError, match="No such file"):
        open_counter(UsbCtrSettings(fpga_image=Path("usb-ctr.rbf")), context)
    assert backend.closed == 1


def test_a_transport_that_is_not_a_usb_backend_is_refused() -> None:
    with pytest.raises(InputError, match="a transport of type str"):
        open_counter(UsbCtrSettings(), BenchContext(transport="COM3"))


def test_without_libusb_the_driver_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_backend(**_: object) -> None:
        raise core.NoBackendError("No backend available")

    monkeypatch.setattr(core, "find", no_backend)
    told = availability()
    assert not told.ready
    assert "no libusb library on this machine. To do: install libusb 1.0" in told.missing
    assert probe() == ()
    with pytest.raises(DriverUnavailable, match="libusb"):
        open_counter(UsbCtrSettings(), BenchContext())


def test_the_driver_is_ready_only_with_the_maker_s_image(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("drivers.usb_ctr.plugin.find_pipes", lambda: find_pipes(Backend([])))
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
    backend = Backend([b"01234567"], status=b"\x00\x00")
    with pytest.raises(DeviceRefused, match=r"not configured after USB_CTR.rbf"):
        open_counter(UsbCtrSettings(), BenchContext(transport=backend))
    assert backend.transfers[0] == "50 0 0 ad"


def test_probing_names_boards_and_what_keeps_one_from_answering(monkeypatch: pytest.MonkeyPatch) -> None:
    backend = Backend([b"01234567"])
    monkeypatch.setattr("drivers.usb_ctr.plugin.find_pipes", lambda: find_pipes(backend))
    assert probe() == ("USB-CTR08 01234567",)
    backend.error = core.USBError("Access denied", -3, errno.EACCES)
    assert "Access denied" in probe()[0]
