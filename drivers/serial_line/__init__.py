"""What every driver on a serial line shares: the port, and lines out and in with their time-outs."""

from drivers.serial_line.lines import Answer, LineWire
from drivers.serial_line.port import (
    BITS_PER_BYTE,
    SerialPort,
    availability,
    open_port,
    port_gone,
    probe,
    stopped_before,
)

__all__ = [
    "BITS_PER_BYTE",
    "Answer",
    "LineWire",
    "SerialPort",
    "availability",
    "open_port",
    "port_gone",
    "probe",
    "stopped_before",
]
