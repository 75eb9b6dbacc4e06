"""A GRBL 1.1 controller as a byte machine, behind a pyserial port.

Written from the hardware sheet alone (``zaber-and-grbl.md``, sections 3, 5 and 6), never from a driver.
Of G-code it knows jogs only.
"""

from sim_backends.wire.grbl.board import GrblBoard
from sim_backends.wire.grbl.settings import GrblEmulatorSettings

__all__ = ["GrblBoard", "GrblEmulatorSettings"]
