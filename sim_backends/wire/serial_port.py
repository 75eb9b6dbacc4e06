"""A pyserial port at whose other end a device stands."""

from typing import TYPE_CHECKING, Protocol

import serial

from sim_backends.bench import BenchClock, RealTimeClock

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

_SLICE_S = 0.005
"""Time that a read sleeps, on a clock that really waits, before it looks for what other threads have sent."""


class SerialDevice(Protocol):
    """A device at the end of a serial line."""

    @property
    def clock(self) -> BenchClock:
        """The bench's."""
        ...

    @property
    def baud(self) -> int:
        """Speed at which it understands bytes."""
        ...

    @property
    def vanished(self) -> bool:
        """Whether the port is gone."""
        ...

    @property
    def received_s(self) -> float:
        """When the last byte of the host has come over the line."""
        ...

    def receive(self, data: bytes) -> None:
        """Take bytes that the host begins to send now."""
        ...

    def send(self) -> bytes:
        """Give the bytes that have arrived at the host since the last call."""
        ...

    def next_s(self) -> float | None:
        """When it is worth looking again. None: never."""
        ...


def emulated_port(device: SerialDevice, name: str) -> "EmulatedPort":
    """Give an open port to ``device``, at its own speed; a driver sets the timeout that it wants."""
    return EmulatedPort(device, name, baudrate=device.baud, timeout=0.1)


class EmulatedPort(serial.SerialBase):
    """What ``serial.Serial`` would be on the real line. A read lets the bench's time pass until its bytes are there.

    In virtual time a read without timeout that nothing will ever answer raises ``SerialException`` instead of hanging.
    """

    def __init__(self, controller: SerialDevice, port: str | None = None, **options: object) -> None:
        """Set up the port; it opens at once where a port name is given, as ``serial.Serial`` does.

        Args:
            controller: the device at the other end of the line.
            port: a name of no meaning, or None to open later.
            options: as of ``serial.Serial``.
        """
        self.controller = controller
        self._arrived = bytearray()
        super().__init__(port, **options)  # type: ignore[arg-type]

    def open(self) -> None:
        """Open the port.

        Raises:
            SerialException: it is open already.
        """
        if self.is_open:
            raise serial.SerialException("the port is already open")
        self._arrived.clear()
        self.is_open = True

    def close(self) -> None:
        """Close the port."""
        self.is_open = False

    def _reconfigure_port(self) -> None:
        """Nothing is behind the options but the baud rate and the time-outs, which are read when they matter."""

    def _update_dtr_state(self) -> None:
        """The line has no handshake."""

    def _update_rts_state(self) -> None:
        """The line has no handshake."""

    def _alive(self) -> SerialDevice:
        if not self.is_open:
            raise serial.PortNotOpenError
        if self.controller.vanished:
            raise serial.SerialException("the device is gone (disconnected?)")
        return self.controller

    def _collect(self) -> int:
        """Take what has arrived by now; give how many bytes there are."""
        self._arrived += self._alive().send()
        return len(self._arrived)

    @property
    def in_waiting(self) -> int:
        """Bytes that have arrived by now."""
        return self._collect()

    @property
    def out_waiting(self) -> int:
        """Bytes that are still on their way to the controller."""
        controller = self._alive()
        left_s = controller.received_s - controller.clock.now_s()
        return max(0, round(left_s * controller.baud / 10))

    def read(self, size: int = 1, /) -> bytes:
        """Give ``size`` bytes, or fewer where the timeout is over first.

        Raises:
            SerialException: the port vanished, or nothing will ever come and there is no timeout.
        """
        clock = self._alive().clock
        deadline_s = None if self.timeout is None else clock.now_s() + self.timeout
        while self.is_open and self._collect() < size:
            now_s = clock.now_s()
            if deadline_s is not None and now_s >= deadline_s:
                break
            times = [time_s for time_s in (deadline_s, self.controller.next_s()) if time_s is not None]
            if isinstance(clock, RealTimeClock):
                times.append(now_s + _SLICE_S)
            if not times:
                raise serial.SerialException("a read without timeout, and nothing is on its way")
            clock.advance_to(max(now_s, min(times)))
        data = bytes(self._arrived[:size])
        del self._arrived[:size]
        return data

    def write(self, b: "ReadableBuffer", /) -> int:
        """Put bytes on the line; returns at once, as a buffered port does.

        Raises:
            SerialException: the port vanished.
        """
        controller, data = self._alive(), bytes(b)
        # At another speed the box sees no command, only framing errors.
        if self.baudrate == controller.baud:
            controller.receive(data)
            self._alive()
        return len(data)

    def flush(self) -> None:
        """Wait until everything written is out."""
        controller = self._alive()
        controller.clock.advance_to(controller.received_s)

    def reset_input_buffer(self) -> None:
        """Throw away what has arrived by now."""
        self._collect()
        self._arrived.clear()

    def reset_output_buffer(self) -> None:
        """Nothing is held back on this side of the line."""
        self._alive()
