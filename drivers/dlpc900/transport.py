"""The 64-byte reports of a HID device: through hidapi, or anything of the same shape."""

from importlib import import_module
from typing import Any, Final, Protocol, runtime_checkable

from drivers.dlpc900.constants import PRODUCT_ID, VENDOR_ID
from protocols import DriverUnavailable

REPORT: Final = 64


@runtime_checkable
class HidReports(Protocol):
    """A HID device that is open."""

    def write(self, report: bytes) -> None:
        """Send one report of 64 bytes.

        Raises:
            OSError: the device is gone.
        """
        ...

    def read(self, timeout_s: float) -> bytes:
        """Give the next report, or nothing where none comes in ``timeout_s``.

        Raises:
            OSError: the device is gone.
        """
        ...

    def close(self) -> None:
        """Let go of the device."""
        ...


class HidApi:
    """A device opened by hidapi, which works beside TI's own program, without another driver."""

    def __init__(self, serial_number: str, device: str) -> None:
        """Open the device with this serial number; an empty one takes the first.

        Raises:
            DriverUnavailable: no hidapi, no device, or no leave to open it.
        """
        try:
            hid: Any = import_module("hid")  # an optional extra
        except ImportError as error:
            raise DriverUnavailable(
                device=device,
                saw="no hidapi",
                expected="the Python package hidapi",
                remedy="install it: pip install 'kinopix[dlpc900]'",
            ) from error
        self._device: Any = hid.device()
        try:
            self._device.open(VENDOR_ID, PRODUCT_ID, serial_number or None)
        except OSError as error:
            raise DriverUnavailable(
                device=device,
                saw=f"no DLPC900 that can be opened ({error})",
                expected=f"USB device {VENDOR_ID:04x}:{PRODUCT_ID:04x}",
                remedy="check cable and power; close TI's program; on Linux give yourself leave by a udev rule",
            ) from error

    def write(self, report: bytes) -> None:
        """See ``HidReports``. Report number 0 stands in front."""
        if self._device.write(b"\x00" + report) < 0:
            raise OSError(self._device.error())

    def read(self, timeout_s: float) -> bytes:
        """See ``HidReports``."""
        return bytes(self._device.read(REPORT, max(1, round(1000 * timeout_s))))

    def close(self) -> None:
        """See ``HidReports``."""
        self._device.close()
