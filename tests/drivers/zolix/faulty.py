"""Two tiny controllers whose answers can be late, doubled, cut or lost. In order, like a serial line."""

import math
from collections import deque
from typing import Literal

from tests.drivers.zolix.scripted import VirtualClock

Fault = Literal["late", "twice", "partly", "lost"]
LATE_S = 1.3
BYTE_S = 10 / 19200


class FaultyController:
    """A stage of constant velocity, 20 mm/s at 400 pulses a millimetre, behind a serial port."""

    def __init__(self, clock: VirtualClock) -> None:
        self.timeout: float | None = None
        self.faults: deque[Fault | None] = deque()
        self._clock = clock
        self._typed = b""
        self._free_s = 0.0
        self._out: list[tuple[float, bytes]] = []
        self._from = self._to = 0.0
        self._began_s = self._ends_s = 0.0
        self._told = True

    def true_pulses(self, time_s: float) -> float:
        """Where the stage is."""
        if time_s >= self._ends_s:
            return self._to
        return self._from + (self._to - self._from) * (time_s - self._began_s) / (self._ends_s - self._began_s)

    @property
    def moving(self) -> bool:
        """Whether it moves now."""
        return self._clock.time_s < self._ends_s

    @property
    def in_waiting(self) -> int:
        """Bytes that have arrived."""
        self._live()
        return sum(at_s <= self._clock.time_s for at_s, _ in self._out)

    def read(self, size: int = 1, /) -> bytes:
        """Take what has arrived."""
        size = min(size, self.in_waiting)
        taken, self._out = self._out[:size], self._out[size:]
        return b"".join(byte for _, byte in taken)

    def write(self, b: bytes, /) -> int:
        """Obey."""
        self._live()
        self._typed += b
        while b"\r" in self._typed:
            line, self._typed = self._typed.split(b"\r", 1)
            self.obey(line.decode("ascii"))
        return len(b)

    def reset_input_buffer(self) -> None:
        """Forget what has arrived."""
        self._out = []

    def close(self) -> None:
        """Nothing to close."""

    def obey(self, line: str) -> None:
        """Carry out one command."""
        raise NotImplementedError

    def ending(self) -> bytes:
        """The line at the end of a move."""
        raise NotImplementedError

    def answer(self, line: bytes, at_s: float | None = None) -> None:
        """Send a line, spoilt by the next fault."""
        fault = self.faults.popleft() if self.faults else None
        whole = line + b"\r"
        data = {"twice": whole * 2, "partly": whole[: len(whole) // 2], "lost": b""}.get(fault or "", whole)
        begin_s = max(self._free_s, self._clock.time_s if at_s is None else at_s) + (
            LATE_S if fault == "late" else 0.002
        )
        for index, byte in enumerate(data):
            self._free_s = begin_s + (index + 1) * BYTE_S
            self._out.append((self._free_s, bytes([byte])))

    def go(self, target: float) -> None:
        """Move at constant velocity."""
        now_s = self._clock.time_s
        self._from, self._to, self._began_s = self.true_pulses(now_s), target, now_s
        self._ends_s = now_s + abs(self._to - self._from) / 8000
        self._told = math.isclose(self._from, self._to)

    def halt(self) -> None:
        """Stop on the spot, on a whole pulse."""
        if self.moving:
            self._to = float(round(self.true_pulses(self._clock.time_s)))
            self._ends_s = self._clock.time_s

    def _live(self) -> None:
        if not self._told and not self.moving:
            self._told = True
            self.answer(self.ending(), max(self._ends_s, 0.0))


class FaultyMc600(FaultyController):
    """Answers during motion."""

    def ending(self) -> bytes:
        """As in production code: axis, blank, position, OK."""
        return f"X {self._to:.1f},OK".encode()

    def obey(self, line: str) -> None:
        """The verbs that the driver may use."""
        verb, _, rest = line.partition(" ")
        match verb.upper():
            case "VE":
                self.answer(b"E01")
            case "POSITION?":
                self.answer(f"POSITION? X,{self.true_pulses(self._clock.time_s):.1f},OK".encode())
            case "SETUNIT?":
                self.answer(b"SETUNIT? X,s,OK")
            case "GOPOSITION":
                _, _, kind, sign, number = rest.split(",")
                distance = (-1 if sign == "N" else 1) * float(number)
                self.answer(b"READY")
                self.go(distance + (self.true_pulses(self._clock.time_s) if kind == "R" else 0))
            case "STOP":
                self.halt()
                self.answer(b"OK")
            case _:
                self.answer(b"OK")


class FaultySc300(FaultyController):
    """Mute during motion: what is asked then is never answered."""

    def ending(self) -> bytes:
        """Of the same form as a position."""
        return f"?X,{self._to:.0f}".encode()

    def obey(self, line: str) -> None:
        """The commands that the driver may use."""
        if line == "SPX":
            self.halt()
        elif not self.moving:
            self._idle(line)

    def _idle(self, line: str) -> None:
        here = self.true_pulses(self._clock.time_s)
        match line[:1]:
            case "?":
                self.answer(f"?X,{here:.0f}".encode())
            case "+" | "-":
                self.go(here + int(line[0] + line[3:]))
            case "V" if line == "VE":
                self.answer(b"SC300_V1.0")
            case _:
                self.answer(b"OK")
