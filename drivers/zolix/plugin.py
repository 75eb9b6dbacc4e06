"""Entry point ``kinopix.stages``: ``ka400z``."""

import serial
from serial.tools import list_ports

from drivers.zolix.driver import Ka400z
from drivers.zolix.settings import Ka400zSettings
from protocols import Availability, DriverPlugin


def availability() -> Availability:
    """Pyserial is a dependency of the product, so the driver can always be used."""
    return Availability(ready=True, version=f"pyserial {serial.__version__}")


def probe() -> tuple[str, ...]:
    """List the serial ports of this machine. Sends nothing: another device may be on any of them."""
    return tuple(f"{port.device}: {port.description}" for port in list_ports.comports())


plugin = DriverPlugin(
    summary="Zolix KA400Z linear stage on an MC600 or SC300 controller, over a serial line",
    settings=Ka400zSettings,
    open=Ka400z,
    availability=availability,
    probe=probe,
)
