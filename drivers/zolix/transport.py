"""The serial port, as far as this driver uses one: a pyserial port, a pyserial URL, or anything of the same shape."""

from typing import Final, Protocol, runtime_checkable

import serial

from protocols import DriverUnavailable, InputError

BAUD: Final = 19200
"""8 data bits, no parity, 1 stop bit, no flow control, for both dialects (fact sheet, sections 3A and 3B)."""


@runtime_checkable
class SerialPort(Protocol):
    """What the driver needs of a port. Reading never blocks: ``timeout`` is set to 0."""

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


def open_port(port: str, transport: object | None, device: str) -> SerialPort:
    """Open ``port``, or use what ``transport`` gives: an open port object, or a URL of one.

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
            remedy="set port in the [stage] table of bench.toml; `kinopix drivers probe` lists the ports",
        )
    try:
        opened: SerialPort = serial.serial_for_url(port, baudrate=BAUD, timeout=0, exclusive=True)
    except (OSError, ValueError) as error:
        raise DriverUnavailable(
            device=device,
            saw=f"port {port!r} that cannot be opened ({error})",
            expected="a serial port that is there and that nobody else holds",
            remedy="check the cable and the name of the port, and close other programs that use it",
        ) from error
    return opened


def _adopt(transport: object, device: str) -> SerialPort:
    if not isinstance(transport, SerialPort):
        raise InputError(
            device=device,
            saw=f"a transport of type {type(transport).__name__}",
            expected="an open pyserial port, or the URL of one",
            remedy="choose a transport for Zolix controllers in bench.toml",
        )
    transport.timeout = 0
    return transport
