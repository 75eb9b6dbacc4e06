"""A serial counter as a byte machine, behind a pyserial port or a pseudo-terminal.

Written from ``docs/reference/serial-counter.md`` alone, never from the driver.
"""

from sim_backends.wire.serial_counter.box import CounterBox
from sim_backends.wire.serial_counter.settings import SerialCounterEmulatorSettings

__all__ = ["CounterBox", "SerialCounterEmulatorSettings"]
