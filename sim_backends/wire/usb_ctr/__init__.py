"""A Measurement Computing USB-CTR04 or 08 as the package usb1 shows one.

Written from the hardware sheet alone (``h10682-daq.md``, sections 5, 11 and 12), never from a driver.
"""

from sim_backends.wire.usb_ctr.context import UsbCtrContext
from sim_backends.wire.usb_ctr.plugin import open_emulator, plugin
from sim_backends.wire.usb_ctr.settings import UsbCtrEmulatorSettings

__all__ = ["UsbCtrContext", "UsbCtrEmulatorSettings", "open_emulator", "plugin"]
