"""A tiny host: raw lines on an emulated port, in virtual time."""

from sim_backends.wire.serial_box import SerialBox
from sim_backends.wire.serial_port import EmulatedPort


class Host:
    """A port of a second's patience."""

    def __init__(self, box: SerialBox, baud: int = 115_200) -> None:
        self.clock = box.clock
        self.port = EmulatedPort(box, "emulated", baudrate=baud, timeout=1.0)

    def ask(self, sent: bytes) -> bytes:
        """Send bytes; give the next line, or what came in a second if none did."""
        self.port.write(sent)
        return self.line()

    def line(self) -> bytes:
        """Next line with its end, or what came in a second."""
        return bytes(self.port.read_until(b"\n"))

    def rest(self, wait_s: float = 60.0) -> bytes:
        """Everything that comes in a while."""
        self.clock.sleep_s(wait_s)
        return self.port.read(self.port.in_waiting)
