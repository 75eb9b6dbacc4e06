"""The one place that touches ``pyusb``: control transfers, one bulk endpoint, and USB errors turned into ``UsbFault``."""

import errno
from collections.abc import Generator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, Protocol

from drivers.h10682.detector import NAME
from drivers.usb_ctr.codec import PRODUCTS, SCAN_ENDPOINT, VENDOR_ID
from protocols import InputError

_IN, _OUT = 0xC0, 0x40
_CONTROL_TIMEOUT_MS = 1000
_BULK_TIMEOUT_MS = 1  # libusb takes 0 for "for ever"
_BULK_BYTES = 512
_INTERFACE = 0


class UsbFault(Exception):
    """A transfer that failed. ``errno`` is the operating system's number, or None."""

    def __init__(self, text: str, number: int | None = None) -> None:
        """Keep pyusb's words and number."""
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

    def packet(self) -> bytes:
        """One packet of scan data that is there already; empty where none is."""
        ...

    def claim(self) -> None:
        """Take the board's interface, which one program can hold; before it, only ``ask`` and ``tell`` work everywhere."""
        ...

    def clear_halt(self) -> None:
        """Clear a halt of the scan endpoint, on an interface that is claimed."""
        ...

    def close(self) -> None:
        """Give the device back to the operating system."""
        ...


def find_pipes(transport: object | None = None) -> list[UsbPipe]:
    """Every USB-CTR board, through ``transport`` (a ``usb.backend.IBackend``) or libusb where it is None.

    Raises:
        UsbFault: no libusb on this machine, or the bus cannot be read.
        InputError: the transport is something else.
    """
    core: Any = import_module("usb.core")
    if transport is not None and not hasattr(transport, "ctrl_transfer"):
        raise InputError(
            device=NAME,
            saw=f"a transport of type {type(transport).__name__}",
            expected="a usb.backend.IBackend",
            remedy="name a transport that is made for the USB-CTR in bench.toml",
        )
    with _faults():
        found: Any = core.find(find_all=True, backend=transport, idVendor=VENDOR_ID)
        return [_PyusbPipe(device) for device in found if int(device.idProduct) in PRODUCTS]


@contextmanager
def _faults() -> Generator[None]:
    core: Any = import_module("usb.core")
    try:
        yield
    except core.NoBackendError as error:
        raise UsbFault("no libusb library on this machine") from error
    except NotImplementedError as error:  # how pyusb tells of LIBUSB_ERROR_NOT_SUPPORTED
        raise UsbFault(str(error) or "operation not supported", errno.ENOTSUP) from error
    except core.USBError as error:
        number: int | None = error.errno
        raise UsbFault(str(error), number) from error


class _PyusbPipe:
    def __init__(self, device: Any) -> None:
        self._device = device

    @property
    def product_id(self) -> int:
        return int(self._device.idProduct)

    def ask(self, command: int, value: int, index: int, n_bytes: int) -> bytes:
        with _faults():
            return bytes(self._device.ctrl_transfer(_IN, command, value, index, n_bytes, _CONTROL_TIMEOUT_MS))

    def tell(self, command: int, value: int, index: int, data: bytes) -> None:
        with _faults():
            sent = int(self._device.ctrl_transfer(_OUT, command, value, index, data, _CONTROL_TIMEOUT_MS))
        if sent != len(data):
            raise UsbFault(f"{sent} of {len(data)} bytes taken", errno.EIO)

    def packet(self) -> bytes:
        try:
            with _faults():
                return bytes(self._device.read(SCAN_ENDPOINT, _BULK_BYTES, _BULK_TIMEOUT_MS))
        except UsbFault as fault:
            timeout_error: Any = import_module("usb.core").USBTimeoutError
            if isinstance(fault.__cause__, timeout_error) or fault.errno == errno.ETIMEDOUT:
                return b""
            raise

    def claim(self) -> None:
        core, util = import_module("usb.core"), import_module("usb.util")
        with _faults():
            try:
                self._device.get_active_configuration()
            except core.USBError:
                self._device.set_configuration()
            util.claim_interface(self._device, _INTERFACE)

    def clear_halt(self) -> None:
        with _faults():
            self._device.clear_halt(SCAN_ENDPOINT)

    def close(self) -> None:
        util: Any = import_module("usb.util")
        with _faults():
            util.dispose_resources(self._device)
