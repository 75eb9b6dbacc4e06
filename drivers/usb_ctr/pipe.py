"""The one place that touches libusb (package ``usb1``): control transfers, one bulk endpoint, errors turned into ``UsbFault``."""

import errno
from collections import deque
from collections.abc import Generator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, Final, Protocol

from drivers.h10682.detector import NAME
from drivers.usb_ctr.codec import PRODUCTS, SCAN_ENDPOINT, VENDOR_ID
from protocols import InputError

IN_FLIGHT: Final = 32
"""Bulk transfers that wait for a packet at the same time, as in the maker's library (uldaq). With one, a packet comes for each
answer that a computer waits for, at most 8,000 a second; queued, several come in a microframe of 125 us."""

_REQUEST: Final = 0x40
_CONTROL_TIMEOUT_MS: Final = 1000
_WAIT_S: Final = 1e-3
"""How long a packet is waited for that is not there yet: longer than the bus takes between the packets of a full queue."""

_CANCELS_S: Final = 1.0
_BULK_BYTES: Final = 512
_INTERFACE: Final = 0

_ERRNO: Final = {
    -1: errno.EIO, -2: errno.EINVAL, -3: errno.EACCES, -4: errno.ENODEV, -5: errno.ENOENT, -6: errno.EBUSY, -7: errno.ETIMEDOUT,
    -8: errno.EOVERFLOW, -9: errno.EPIPE, -10: errno.EINTR, -11: errno.ENOMEM, -12: errno.ENOTSUP,
}  # fmt: skip
"""The operating system's number for each of libusb's."""

_ENDED: Final = {
    1: ("transfer failed", errno.EIO), 2: ("transfer timed out", errno.ETIMEDOUT), 4: ("endpoint halted", errno.EPIPE),
    5: ("no such device (it may have been disconnected)", errno.ENODEV), 6: ("packet too long", errno.EOVERFLOW),
}  # fmt: skip
"""How a transfer ends that neither is complete (0) nor was cancelled (3)."""


class UsbFault(Exception):
    """A transfer that failed. ``errno`` is the operating system's number, or None."""

    def __init__(self, text: str, number: int | None = None) -> None:
        """Keep libusb's words and number."""
        super().__init__(text)
        self.text = " ".join(text.split()).rstrip(".")
        self.errno = number


class UsbPipe(Protocol):
    """One USB-CTR board. Every method raises ``UsbFault``."""

    @property
    def product_id(self) -> int:
        """Which board it is."""
        ...

    def ask(self, command: int, value: int, index: int, n_bytes: int) -> bytes:
        """Vendor control transfer in."""
        ...

    def tell(self, command: int, value: int, index: int, data: bytes) -> None:
        """Vendor control transfer out."""
        ...

    def claim(self) -> None:
        """Take the board's interface, which one program can hold; before it, only ``ask`` and ``tell`` work everywhere."""
        ...

    def clear_halt(self) -> None:
        """Clear a halt of the scan endpoint, on an interface that is claimed."""
        ...

    def begin_packets(self) -> None:
        """Queue transfers for the packets of a scan that is about to start."""
        ...

    def packet(self) -> bytes:
        """The next packet of scan data that has come; empty where none has. What came before a failure comes before it."""
        ...

    def end_packets(self) -> None:
        """Cancel what waits for packets, and forget packets that nobody took."""
        ...

    def close(self) -> None:
        """Give the device back to the operating system."""
        ...


def find_pipes(transport: object | None = None) -> list[UsbPipe]:
    """Every USB-CTR board, through ``transport`` (a ``usb1.USBContext``, or what behaves like one) or libusb where it is None.

    Raises:
        UsbFault: no libusb on this machine, or the bus cannot be read.
        InputError: the transport is something else.
    """
    if transport is not None and not hasattr(transport, "getDeviceIterator"):
        raise InputError(
            device=NAME,
            saw=f"a transport of type {type(transport).__name__}",
            expected="a usb1.USBContext",
            remedy="name a transport that is made for the USB-CTR in bench.toml",
        )
    bus = _Bus(transport)
    try:
        with _faults():
            found: list[Any] = list(bus.context.getDeviceIterator(skip_on_error=True))
            boards = [device for device in found if device.getVendorID() == VENDOR_ID]
        return [_LibusbPipe(bus, device) for device in boards if device.getProductID() in PRODUCTS]
    finally:
        bus.release()


@contextmanager
def _faults() -> Generator[None]:
    usb1: Any = import_module("usb1")
    try:
        yield
    except usb1.USBError as error:
        raise UsbFault(str(error), _ERRNO.get(error.value, errno.EIO)) from error


class _Bus:
    """libusb for as long as somebody uses it: the finder of boards, and each pipe that is not closed."""

    def __init__(self, transport: object | None) -> None:
        self._users = 1
        self._own = transport is None
        self.context: Any = transport
        if transport is None:
            try:
                with _faults():
                    self.context = import_module("usb1").USBContext().open()
            except OSError as error:  # how usb1 tells that there is no such library
                raise UsbFault("no libusb library on this machine") from error

    def hold(self) -> None:
        self._users += 1

    def release(self) -> None:
        self._users -= 1
        if self._own and not self._users:
            self.context.close()


class _LibusbPipe:
    def __init__(self, bus: _Bus, device: Any) -> None:
        bus.hold()
        self._bus: _Bus | None = bus
        self._context = bus.context
        self._device = device
        self._opened: Any = None
        self._queued: list[Any] = []
        self._packets: deque[bytes] = deque()
        self._fault: UsbFault | None = None
        self._ending = False

    @property
    def product_id(self) -> int:
        return int(self._device.getProductID())

    @property
    def _handle(self) -> Any:
        if self._opened is None:
            self._opened = self._device.open()
        return self._opened

    def ask(self, command: int, value: int, index: int, n_bytes: int) -> bytes:
        with _faults():
            return bytes(self._handle.controlRead(_REQUEST, command, value, index, n_bytes, _CONTROL_TIMEOUT_MS))

    def tell(self, command: int, value: int, index: int, data: bytes) -> None:
        with _faults():
            sent = int(self._handle.controlWrite(_REQUEST, command, value, index, data, _CONTROL_TIMEOUT_MS))
        if sent != len(data):
            raise UsbFault(f"{sent} of {len(data)} bytes taken", errno.EIO)

    def claim(self) -> None:
        with _faults():
            if not self._handle.getConfiguration():
                self._handle.setConfiguration(1)
            self._handle.claimInterface(_INTERFACE)

    def clear_halt(self) -> None:
        with _faults():
            self._handle.clearHalt(SCAN_ENDPOINT)

    def begin_packets(self) -> None:
        self.end_packets()
        self._ending = False
        with _faults():
            for _ in range(IN_FLIGHT):
                transfer = self._handle.getTransfer()
                transfer.setBulk(SCAN_ENDPOINT, _BULK_BYTES, callback=self._came)
                transfer.submit()
                self._queued.append(transfer)

    def packet(self) -> bytes:
        if not self._packets and self._queued and self._fault is None:
            with _faults():
                self._context.handleEventsTimeout(_WAIT_S)
        if self._packets:
            return self._packets.popleft()
        if self._fault is not None:
            raise self._fault
        return b""

    def end_packets(self) -> None:
        self._ending = True
        usb1: Any = import_module("usb1")
        for transfer in self._queued:
            if transfer.isSubmitted():
                try:
                    transfer.cancel()
                except usb1.USBError:
                    continue  # it is over, and its end is on its way; or the board is gone, which ends it too
        waits = 0
        while any(transfer.isSubmitted() for transfer in self._queued) and waits * _WAIT_S < _CANCELS_S:
            with _faults():
                self._context.handleEventsTimeout(_WAIT_S)
            waits += 1
        for transfer in self._queued:
            if not transfer.isSubmitted():
                transfer.close()
        self._queued.clear()
        self._packets.clear()
        self._fault = None

    def close(self) -> None:
        bus, self._bus = self._bus, None
        if bus is None:
            return
        try:
            self.end_packets()
            if self._opened is not None:
                with _faults():
                    self._opened.close()
        finally:
            bus.release()

    def _came(self, transfer: Any) -> None:
        """Keep what a transfer has brought, and queue it again. libusb calls this from ``handleEventsTimeout``."""
        if length := transfer.getActualLength():
            self._packets.append(bytes(transfer.getBuffer()[:length]))
        if self._ending or self._fault is not None:
            return
        ended = transfer.getStatus()
        if ended:
            self._fault = UsbFault(*_ENDED.get(ended, ("transfer cancelled", errno.EIO)))
            return
        try:
            with _faults():
                transfer.submit()
        except UsbFault as fault:
            self._fault = fault
