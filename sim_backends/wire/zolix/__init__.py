"""Zolix MC600 and SC300 controllers as byte machines, behind a pyserial port.

Written from the hardware sheet alone (``ka400z.md``, sections 3 and 5), never from a driver.
"""

from sim_backends.wire.serial_port import EmulatedPort
from sim_backends.wire.zolix.controller import EmulatedController
from sim_backends.wire.zolix.mc600 import mc600_controller
from sim_backends.wire.zolix.sc300 import sc300_controller
from sim_backends.wire.zolix.settings import Mc600Settings, Sc300Settings

__all__ = [
    "EmulatedController",
    "EmulatedPort",
    "Mc600Settings",
    "Sc300Settings",
    "mc600_controller",
    "sc300_controller",
]
