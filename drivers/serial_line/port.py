"""A serial port, as far as the drivers use one: a pyserial port, a pyserial URL, or anything of the same shape."""

from typing import Final, Protocol, runtime_checkable

import serial
from serial.tools import list_ports

from protocols import Availability, DeviceDisconnected, DeviceError, DriverUnavailable, InputError

BITS_PER_BYTE: Final = 10
"""Start bit, 8 data bits, no parity, 1 stop bit: the line of every device here, without flow control."""


@runtime_checkable
class SerialPort(Protocol):
    """What a driver needs of a port. Reading never blocks: ``timeout`` is set to 0."""

    @property
    def timeout(self) -> float | None:
        """How long ``read`` waits."""
        ...

    @timeout.setter
    def timeout(self, timeout: float | None, /) -> None: ...

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read at once."""
        ...

    def read(self, size: int = 1, /) -> bytes:
        """Read up to ``size`` bytes."""
        ...

    def write(self, b: bytes, /) -> int | None:
        """Write all of ``b``."""
        ...

    def reset_input_buffer(self) -> None:
        """Throw away what came before."""
        ...

    def close(self) -> None:
        """Give the port back."""
        ...


def open_port(port: str, transport: object | None, *, device: str, table: str, baud: int) -> SerialPort:
    """Open ``port``, or use what ``transport`` gives: an open port object, or a URL of one.

    Args:
        port: name of a serial port or pyserial URL, from ``table``.
        transport: what bench.toml names instead, or None.
        device: name that errors carry.
        table: name of the device's table in bench.toml.
        baud: speed of the line.

    Raises:
        InputError: neither is given, or ``transport`` is neither a URL nor a port.
        DriverUnavailable: the port is not there or somebody else holds it.
    """
    if isinstance(transport, str):
        port = transport
    elif transport is not None:
        return _adopt(transport, device)
    if not port:
        raise InputError(
            device=device,
            saw="no port",
            expected="the name of a serial port or a pyserial URL",
            remedy=f"set port in the [{table}] table of bench.toml; `kinopix drivers probe` lists the ports",
        )
    try:
        opened: SerialPort = serial.serial_for_url(port, baudrate=baud, timeout=0, exclusive=True)
    except (OSError, ValueError) as error:
        raise DriverUnavailable(
            device=device,
            saw=f"port {port!r} that cannot be opened ({error})",
            expected="a serial port that is there and that nobody else holds",
            remedy="check the cable and the name of the port, and close other programs that use it",
        ) from error
    return opened


def port_gone(device: str, error: OSError) -> DeviceDisconnected:
    """Give the error of a port that fails under the hands."""
    return DeviceDisconnected(
        device=device,
        saw=f"a serial port that fails ({error})",
        expected="an open port",
        remedy="check cable and power, switch the device off by hand if it moves, and open it again",
    )


def stopped_before(device: str) -> DeviceError:
    """Give the error of a move that a stop overtook."""
    return DeviceError(
        device=device,
        saw="a stop before the move had begun",
        expected="no stop between the call and the move",
        remedy="start the move again if it is still wanted; nothing was sent",
    )


def availability() -> Availability:
    """Pyserial is a dependency of the product, so a driver on a serial line can always be used."""
    return Availability(ready=True, version=f"pyserial {serial.__version__}")


def probe() -> tuple[str, ...]:
    """List the serial ports of this machine. Sends nothing: another device may be on any of them."""
    return tuple(f"{port.device}: {port.description}" for port in list_ports.comports())


def _adopt(transport: object, device: str) -> SerialPort:
    if not isinstance(transport, SerialPort):
        raise InputError(
            device=device,
            saw=f"a transport of type {type(transport).__name__}",
            expected="an open pyserial port, or the URL of one",
            remedy="choose a transport for this driver in bench.toml",
        )
    transport.timeout = 0
    return transport
