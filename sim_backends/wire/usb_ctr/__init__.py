"""A Measurement Computing USB-CTR04 or 08 as a pyusb backend.

Written from the hardware sheet alone (``h10682-daq.md``, sections 5, 11 and 12), never from a driver.
"""

from sim_backends.wire.usb_ctr.backend import UsbCtrBackend
from sim_backends.wire.usb_ctr.plugin import open_emulator, plugin
from sim_backends.wire.usb_ctr.settings import UsbCtrEmulatorSettings

__all__ = ["UsbCtrBackend", "UsbCtrEmulatorSettings", "open_emulator", "plugin"]
