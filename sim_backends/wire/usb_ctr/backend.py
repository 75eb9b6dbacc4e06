"""A pyusb backend on which one USB-CTR is plugged in.

The one place that touches pyusb, which is untyped.
"""

# ruff: noqa: ARG002, PLR0917  (the signatures are pyusb's)

import errno
from array import array
from types import SimpleNamespace
from typing import Any

import usb.backend
import usb.core

from sim_backends.wire.usb_ctr.board import EmulatedUsbCtrBoard
from sim_backends.wire.usb_ctr.requests import Gone, Stall, TimedOut
from sim_backends.wire.usb_ctr.settings import NoAccess, UsbCtrEmulatorSettings

VENDOR_ID = 0x09DB
PRODUCT_IDS = {"USB-CTR04": 0x012E, "USB-CTR08": 0x0127}
BULK_IN = 0x86
_VENDOR_OUT, _VENDOR_IN, _STANDARD_IN = 0x40, 0xC0, 0x80
_GET_DESCRIPTOR, _STRING = 0x06, 0x03
_IBackend: Any = usb.backend.IBackend


class Handle:
    """An open device."""

    def __init__(self) -> None:
        self.claimed: set[int] = set()


def _error(text: str, code: int, number: int) -> Exception:
    """A USBError with libusb's code and the host's errno."""
    kind: Any = usb.core.USBTimeoutError if number == errno.ETIMEDOUT else usb.core.USBError
    error: Exception = kind(text, code, number)
    return error


def _no_device() -> Exception:
    return _error("No such device (it may have been disconnected)", -4, errno.ENODEV)


class UsbCtrBackend(_IBackend):  # type: ignore[misc]
    """``usb.backend.IBackend`` for ``usb.core.find(backend=...)``: one device, one configuration, one interface."""

    def __init__(self, board: EmulatedUsbCtrBoard) -> None:
        self.board = board
        self.transcript: list[tuple[int, int, int, int, bytes]] = []
        """bmRequestType, bRequest, wValue, wIndex and data of each vendor transfer, in order, for tests."""
        settings = board.settings
        self._settings: UsbCtrEmulatorSettings = settings
        self._strings = {1: "MCC", 2: settings.model, 3: settings.serial_number}
        self._holder: Handle | None = None

    def _refuses(self, kind: str) -> bool:
        return any(isinstance(fault, NoAccess) and fault.kind == kind for fault in self._settings.faults)

    # Descriptors

    def enumerate_devices(self) -> list[EmulatedUsbCtrBoard]:
        """The one device, as long as it is there."""
        return [] if self.board.gone else [self.board]

    def get_parent(self, dev: object) -> None:
        """Plugged into the host itself."""

    def get_device_descriptor(self, dev: object) -> SimpleNamespace:
        """Who the device is."""
        return SimpleNamespace(
            bLength=18, bDescriptorType=1, bcdUSB=0x0200, bDeviceClass=0xFF, bDeviceSubClass=0xFF, bDeviceProtocol=0xFF,
            bMaxPacketSize0=64, idVendor=VENDOR_ID, idProduct=PRODUCT_IDS[self._settings.model], bcdDevice=0x0101,
            iManufacturer=1, iProduct=2, iSerialNumber=3, bNumConfigurations=1,
            address=2, bus=1, port_number=1, port_numbers=(1,), speed=3 if self._settings.high_speed else 2,
        )  # fmt: skip

    def get_configuration_descriptor(self, dev: object, config: int) -> SimpleNamespace:
        """The one configuration."""
        if config:
            raise IndexError
        return SimpleNamespace(
            bLength=9, bDescriptorType=2, wTotalLength=25, bNumInterfaces=1, bConfigurationValue=1, iConfiguration=0,
            bmAttributes=0x80, bMaxPower=250, extra_descriptors=[],
        )  # fmt: skip

    def get_interface_descriptor(self, dev: object, intf: int, alt: int, config: int) -> SimpleNamespace:
        """The one interface."""
        if intf or alt or config:
            raise IndexError
        return SimpleNamespace(
            bLength=9, bDescriptorType=4, bInterfaceNumber=0, bAlternateSetting=0, bNumEndpoints=1,
            bInterfaceClass=0xFF, bInterfaceSubClass=0xFF, bInterfaceProtocol=0xFF, iInterface=0, extra_descriptors=[],
        )  # fmt: skip

    def get_endpoint_descriptor(self, dev: object, ep: int, intf: int, alt: int, config: int) -> SimpleNamespace:
        """The endpoint of the scan data."""
        if ep or intf or alt or config:
            raise IndexError
        return SimpleNamespace(
            bLength=7, bDescriptorType=5, bEndpointAddress=BULK_IN, bmAttributes=2,
            wMaxPacketSize=512 if self._settings.high_speed else 64, bInterval=0, bRefresh=0, bSynchAddress=0,
            extra_descriptors=[],
        )  # fmt: skip

    # Life

    def open_device(self, dev: object) -> Handle:
        """Open the device, unless a fault forbids it."""
        if self.board.gone:
            raise _no_device()
        if self._refuses("maker-driver"):
            raise NotImplementedError("Operation not supported or unimplemented on this platform")
        if self._refuses("no-permission"):
            raise _error("Access denied (insufficient permissions)", -3, errno.EACCES)
        return Handle()

    def close_device(self, dev_handle: Handle) -> None:
        """Close it and let go of its interface."""
        if self._holder is dev_handle:
            self._holder = None
        dev_handle.claimed.clear()

    def set_configuration(self, dev_handle: Handle, config_value: int) -> None:
        """Choose the configuration; there is only one."""
        if self.board.gone:
            raise _no_device()
        if config_value not in (0, 1):
            raise _error("Entity not found", -5, errno.ENOENT)
        if self._holder is not None:
            raise _error("Resource busy", -6, errno.EBUSY)

    def get_configuration(self, dev_handle: Handle) -> int:
        """The one configuration."""
        return 1

    def set_interface_altsetting(self, dev_handle: Handle, intf: int, altsetting: int) -> None:
        """There is only one."""

    def claim_interface(self, dev_handle: Handle, intf: int) -> None:
        """Take the interface, which only one handle can hold."""
        if intf != 0:
            raise _error("Entity not found", -5, errno.ENOENT)
        if self._refuses("interface-claimed") or self._holder not in (None, dev_handle):
            raise _error("Resource busy", -6, errno.EBUSY)
        self._holder = dev_handle
        dev_handle.claimed.add(intf)

    def release_interface(self, dev_handle: Handle, intf: int) -> None:
        """Let go of the interface."""
        self.close_device(dev_handle)

    def is_kernel_driver_active(self, dev_handle: Handle, intf: int) -> bool:
        """No kernel driver knows this device."""
        return False

    def detach_kernel_driver(self, dev_handle: Handle, intf: int) -> None:
        """There is none."""
        raise _error("Entity not found", -5, errno.ENOENT)

    def clear_halt(self, dev_handle: Handle, ep: int) -> None:
        """The endpoint never halts. As on Windows and macOS, the interface must be claimed (libusb: NOT_FOUND)."""
        if self.board.gone:
            raise _no_device()
        if self._holder is not dev_handle:
            raise _error("Entity not found", -5, errno.ENOENT)

    def reset_device(self, dev_handle: Handle) -> None:
        """A reset of the port; the FPGA keeps its image."""
        if self.board.gone:
            raise _no_device()

    # Transfers

    def ctrl_transfer(
        self,
        dev_handle: Handle,
        bmRequestType: int,
        bRequest: int,
        wValue: int,
        wIndex: int,
        data: Any,
        timeout: int,
    ) -> int:
        """A control transfer: vendor requests, and the strings of the descriptors."""
        try:
            if bmRequestType == _VENDOR_OUT:
                sent = bytes(data)
                self.transcript.append((bmRequestType, bRequest, wValue, wIndex, sent))
                self.board.write(bRequest, wValue, wIndex, sent, timeout_s=timeout / 1000)
                return len(sent)
            if bmRequestType == _VENDOR_IN:
                told = self.board.read(bRequest, wValue, wIndex, len(data), timeout_s=timeout / 1000)
                self.transcript.append((bmRequestType, bRequest, wValue, wIndex, told))
            elif (bmRequestType, bRequest, wValue >> 8) == (_STANDARD_IN, _GET_DESCRIPTOR, _STRING):
                told = self._string(wValue & 0xFF)[: len(data)]
            else:
                raise Stall
        except Stall as error:
            raise _error("Pipe error", -9, errno.EPIPE) from error
        except TimedOut as error:
            raise _error("Operation timed out", -7, errno.ETIMEDOUT) from error
        except Gone as error:
            raise _no_device() from error
        data[: len(told)] = array("B", told)
        return len(told)

    def _string(self, index: int) -> bytes:
        """A string descriptor; number 0 tells the languages."""
        if index == 0:
            return bytes([4, _STRING, 0x09, 0x04])
        if index not in self._strings:
            raise Stall
        text = self._strings[index].encode("utf-16-le")
        return bytes([len(text) + 2, _STRING]) + text

    def bulk_read(self, dev_handle: Handle, ep: int, intf: int, buff: Any, timeout: int) -> int:
        """Read scan data. As libusb does, data that came before the time was over is no error."""
        if self._holder is not dev_handle or ep != BULK_IN:
            raise _error("Entity not found", -5, errno.ENOENT)
        try:
            data = self.board.bulk_in(len(buff), timeout / 1000)
        except TimedOut as error:
            raise _error("Operation timed out", -7, errno.ETIMEDOUT) from error
        except Gone as error:
            raise _no_device() from error
        except OverflowError as error:
            raise _error("Overflow", -8, errno.EOVERFLOW) from error
        buff[: len(data)] = array("B", data)
        return len(data)
