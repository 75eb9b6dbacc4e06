"""libusb, as the package ``usb1`` shows it, with one USB-CTR plugged in. The one place that touches ``usb1``."""

# ruff: noqa: N802, PLR0917  (names and arguments are usb1's)

from collections.abc import Callable, Iterator
from typing import Any

import usb1

from sim_backends.wire.usb_ctr.board import EmulatedUsbCtrBoard
from sim_backends.wire.usb_ctr.requests import Gone, Stall, TimedOut
from sim_backends.wire.usb_ctr.settings import NoAccess, UsbCtrEmulatorSettings

VENDOR_ID = 0x09DB
PRODUCT_IDS = {"USB-CTR04": 0x012E, "USB-CTR08": 0x0127}
BULK_IN = 0x86
_TYPE, _VENDOR, _STANDARD = 0x7F, 0x40, 0x00
_GET_DESCRIPTOR, _STRING = 0x06, 0x03
_errors: Any = usb1
COMPLETED, ERROR, TIMED_OUT, CANCELLED, NO_DEVICE, OVERFLOW = (
    int(number)
    for number in (
        _errors.TRANSFER_COMPLETED, _errors.TRANSFER_ERROR, _errors.TRANSFER_TIMED_OUT, _errors.TRANSFER_CANCELLED,
        _errors.TRANSFER_NO_DEVICE, _errors.TRANSFER_OVERFLOW,
    )
)  # fmt: skip


class UsbCtrContext:
    """A ``usb1.USBContext``: one device, one configuration, one interface."""

    def __init__(self, board: EmulatedUsbCtrBoard) -> None:
        self.board = board
        self.transcript: list[tuple[int, int, int, int, bytes]] = []
        """bmRequestType, bRequest, wValue, wIndex and data of each vendor transfer, in order, for tests."""
        self.holder: Handle | None = None
        """Who has the interface."""
        self.queue: list[Transfer] = []
        """Transfers that wait for data, in the order of their submission."""

    def getDeviceIterator(self, skip_on_error: bool = False) -> Iterator["Device"]:  # noqa: FBT001, FBT002 - usb1's
        """The one device, as long as it is there."""
        del skip_on_error
        return iter([] if self.board.gone else [Device(self)])

    def handleEventsTimeout(self, tv: float = 0) -> None:
        """End the transfers for which data is there, and those that were cancelled; wait ``tv`` seconds for the first."""
        patience_s = tv
        while self.queue:
            transfer = self.queue[0]
            if not transfer.end(patience_s):
                return
            patience_s = 0.0

    def close(self) -> None:
        """Let go of everything."""


class Device:
    """A ``usb1.USBDevice``."""

    def __init__(self, context: UsbCtrContext) -> None:
        self._context = context
        self._settings: UsbCtrEmulatorSettings = context.board.settings

    def getVendorID(self) -> int:
        """Of the maker."""
        return VENDOR_ID

    def getProductID(self) -> int:
        """Of the model."""
        return PRODUCT_IDS[self._settings.model]

    def getMaxPacketSize(self, endpoint: int) -> int:
        """Of the endpoint of the scan data; there is no other."""
        if endpoint != BULK_IN:
            raise _errors.USBErrorNotFound
        return 512 if self._settings.high_speed else 64

    def open(self) -> "Handle":
        """Open the device, unless a fault forbids it."""
        if self._context.board.gone:
            raise _errors.USBErrorNoDevice
        if self._refuses("maker-driver"):
            raise _errors.USBErrorNotSupported
        if self._refuses("no-permission"):
            raise _errors.USBErrorAccess
        return Handle(self._context, held=self._refuses("interface-claimed"))

    def _refuses(self, kind: str) -> bool:
        return any(isinstance(fault, NoAccess) and fault.kind == kind for fault in self._settings.faults)


class Handle:
    """A ``usb1.USBDeviceHandle``."""

    def __init__(self, context: UsbCtrContext, *, held: bool) -> None:
        self._context = context
        self._board = context.board
        self._held = held
        settings = context.board.settings
        self._strings = {1: "MCC", 2: settings.model, 3: settings.serial_number}

    def close(self) -> None:
        """Cancel what waits, and let go of the interface."""
        for transfer in [transfer for transfer in self._context.queue if transfer.handle is self]:
            transfer.cancel()
        self._context.handleEventsTimeout()
        if self._context.holder is self:
            self._context.holder = None

    def getConfiguration(self) -> int:
        """The one configuration."""
        return 1

    def setConfiguration(self, configuration: int) -> None:
        """Choose the configuration; there is only one."""
        self._must_be_there()
        if configuration not in {0, 1}:
            raise _errors.USBErrorNotFound
        if self._context.holder is not None:
            raise _errors.USBErrorBusy

    def claimInterface(self, interface: int) -> None:
        """Take the interface, which only one handle can hold."""
        if interface:
            raise _errors.USBErrorNotFound
        if self._held or self._context.holder not in {None, self}:
            raise _errors.USBErrorBusy
        self._context.holder = self

    def releaseInterface(self, interface: int) -> None:
        """Let go of the interface."""
        if interface or self._context.holder is not self:
            raise _errors.USBErrorNotFound
        self._context.holder = None

    def kernelDriverActive(self, _interface: int) -> bool:
        """No kernel driver knows this device."""
        return False

    def detachKernelDriver(self, _interface: int) -> None:
        """There is none."""
        raise _errors.USBErrorNotFound

    def clearHalt(self, _endpoint: int) -> None:
        """The endpoint never halts. As on Windows and macOS, the interface must be claimed (libusb: NOT_FOUND)."""
        self._must_be_there()
        self._must_be_claimed()

    def resetDevice(self) -> None:
        """A reset of the port; the FPGA keeps its image."""
        self._must_be_there()

    def controlWrite(
        self, request_type: int, request: int, value: int, index: int, data: bytes, timeout: int = 0
    ) -> int:
        """A vendor request to the device."""
        if request_type & _TYPE != _VENDOR:
            raise _errors.USBErrorPipe
        sent = bytes(data)
        self._context.transcript.append((_VENDOR, request, value, index, sent))
        _told(lambda: self._board.write(request, value, index, sent, timeout_s=timeout / 1000))
        return len(sent)

    def controlRead(
        self, request_type: int, request: int, value: int, index: int, length: int, timeout: int = 0
    ) -> bytearray:
        """A vendor request from the device, or a string of its descriptors."""
        if request_type & _TYPE == _VENDOR:
            told = _told(lambda: self._board.read(request, value, index, length, timeout_s=timeout / 1000))
            self._context.transcript.append((0x80 | _VENDOR, request, value, index, told))
        elif (request_type & _TYPE, request, value >> 8) == (_STANDARD, _GET_DESCRIPTOR, _STRING):
            told = self._string(value & 0xFF)[:length]
        else:
            raise _errors.USBErrorPipe
        return bytearray(told)

    def getASCIIStringDescriptor(self, descriptor: int) -> str:
        """A string of the descriptors."""
        return self._string(descriptor)[2:].decode("utf-16-le")

    def bulkRead(self, endpoint: int, length: int, timeout: int = 0) -> bytearray:
        """Read scan data. As libusb does, data that came before the time was over is no error."""
        if endpoint != BULK_IN:
            raise _errors.USBErrorNotFound
        self._must_be_claimed()
        return bytearray(_told(lambda: self._board.bulk_in(length, timeout / 1000 if timeout else None)))

    def getTransfer(self) -> "Transfer":
        """A transfer that can be submitted."""
        return Transfer(self._context, self)

    def _must_be_there(self) -> None:
        if self._board.gone:
            raise _errors.USBErrorNoDevice

    def _must_be_claimed(self) -> None:
        if self._context.holder is not self:
            raise _errors.USBErrorNotFound

    def _string(self, index: int) -> bytes:
        """A string descriptor; number 0 tells the languages."""
        if index == 0:
            return bytes([4, _STRING, 0x09, 0x04])
        if index not in self._strings:
            raise _errors.USBErrorPipe
        text = self._strings[index].encode("utf-16-le")
        return bytes([len(text) + 2, _STRING]) + text


class Transfer:
    """A ``usb1.USBTransfer`` of the endpoint of the scan data."""

    def __init__(self, context: UsbCtrContext, handle: Handle) -> None:
        self.handle = handle
        self._context = context
        self._length = 0
        self._callback: Callable[[Transfer], object] | None = None
        self._data = b""
        self._status = COMPLETED
        self._cancelled = False

    def setBulk(
        self, endpoint: int, buffer_or_len: int, callback: "Callable[[Transfer], object] | None" = None
    ) -> None:
        """Make it one that reads so many bytes at most."""
        self._refuse_submitted()
        if endpoint != BULK_IN:
            raise _errors.USBErrorNotFound
        self._length, self._callback = buffer_or_len, callback

    def submit(self) -> None:
        """Queue it behind the others."""
        self._refuse_submitted()
        if self._context.board.gone:
            raise _errors.USBErrorNoDevice
        if self._context.holder is not self.handle:
            raise _errors.USBErrorNotFound
        self._cancelled = False
        self._context.queue.append(self)

    def cancel(self) -> None:
        """Ask for its end; it comes with the next events."""
        if not self.isSubmitted():
            raise _errors.USBErrorNotFound
        self._cancelled = True

    def isSubmitted(self) -> bool:
        """Whether it waits for data."""
        return self in self._context.queue

    def getStatus(self) -> int:
        """How it ended."""
        return self._status

    def getActualLength(self) -> int:
        """Bytes that it has brought."""
        return len(self._data)

    def getBuffer(self) -> bytearray:
        """Its buffer, as long as it was asked for."""
        return bytearray(self._data.ljust(self._length, b"\0"))

    def close(self) -> None:
        """Give it back."""
        self._refuse_submitted()
        self._callback = None

    def end(self, patience_s: float) -> bool:
        """End it, if it can be: it was cancelled, or its data is there within so many seconds."""
        self._data = b""
        try:
            if self._cancelled:
                self._status = CANCELLED
            else:
                self._data, self._status = self._context.board.bulk_in(self._length, patience_s), COMPLETED
        except TimedOut:
            return False
        except Gone:
            self._status = NO_DEVICE
        except OverflowError:
            self._status = OVERFLOW
        self._context.queue.remove(self)
        if self._callback is not None:
            self._callback(self)
        return True

    def _refuse_submitted(self) -> None:
        if self.isSubmitted():
            raise ValueError("a submitted transfer")


def _told(action: "Callable[[], Any]") -> Any:
    """Turn what the board does into libusb's errors."""
    try:
        return action()
    except Stall as error:
        raise _errors.USBErrorPipe from error
    except TimedOut as error:
        raise _errors.USBErrorTimeout from error
    except Gone as error:
        raise _errors.USBErrorNoDevice from error
    except OverflowError as error:
        raise _errors.USBErrorOverflow from error
