"""A DLPC900 and its mirrors behind 64-byte HID reports.

Written from the hardware sheet alone (``dlpc900.md``), never from the driver.
"""

from sim_backends.wire.dlpc900.device import EmulatedDlpc900
from sim_backends.wire.dlpc900.settings import Dlpc900EmulatorSettings

__all__ = ["Dlpc900EmulatorSettings", "EmulatedDlpc900"]
