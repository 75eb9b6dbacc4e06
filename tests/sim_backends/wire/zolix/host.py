"""A tiny host: raw bytes on an emulated port, in virtual time."""

from typing import Any

from sim_backends.bench import VirtualClock
from sim_backends.wire.zolix import (
    EmulatedController,
    EmulatedPort,
    Mc600Settings,
    Sc300Settings,
    mc600_controller,
    sc300_controller,
)


class Host:
    """A port of 60 simulated seconds' patience."""

    def __init__(self, controller: EmulatedController) -> None:
        self.controller = controller
        self.clock = controller.clock
        self.port = EmulatedPort(controller, "emulated", baudrate=19_200, timeout=60.0)

    def ask(self, sent: bytes) -> bytes:
        """Send bytes; give the next line, or what came in a second if none did."""
        self.port.write(sent)
        return self.line(1.0)

    def line(self, timeout_s: float = 60.0) -> bytes:
        """Next line with its CR, or what came before the timeout."""
        self.port.timeout = timeout_s
        line = bytearray()
        while not line.endswith(b"\r"):
            byte = self.port.read(1)
            if not byte:
                break
            line += byte
        return bytes(line)

    def rest(self, wait_s: float = 60.0) -> bytes:
        """Everything that comes in a while."""
        self.clock.sleep_s(wait_s)
        return self.port.read(self.port.in_waiting)


def mc600(**settings: Any) -> Host:
    """An MC600 with a lead of 4 mm: 400 pulses a millimetre."""
    return Host(mc600_controller(Mc600Settings.model_validate(settings), VirtualClock()))


def sc300(**settings: Any) -> Host:
    """An SC300 with a lead of 4 mm: 400 pulses a millimetre."""
    return Host(sc300_controller(Sc300Settings.model_validate(settings), VirtualClock()))
