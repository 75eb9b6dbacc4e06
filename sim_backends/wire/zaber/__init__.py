"""A Zaber controller as a byte machine, behind a pyserial port.

Written from the hardware sheet alone (``zaber-and-grbl.md``, sections 2, 5 and 6), never from a driver.
"""

from sim_backends.wire.zaber.device import ZaberDevice
from sim_backends.wire.zaber.settings import ZaberEmulatorSettings

__all__ = ["ZaberDevice", "ZaberEmulatorSettings"]
