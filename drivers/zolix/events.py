"""What both dialects share: the events a line can mean, the commands an intent becomes, and the cutting of bytes into lines."""

from dataclasses import dataclass
from typing import Final, Protocol, TypeAlias

CR: Final = b"\r"
BAUD: Final = 19200
"""8 data bits, no parity, 1 stop bit, no flow control, for both dialects (fact sheet, sections 3A and 3B)."""

LONGEST_LINE: Final = 64
"""Bytes after which a line without a CR is noise: the longest line of either dialect has about 40."""


@dataclass(frozen=True)
class Okay:
    """``OK``: accepted (both), link test (MC600), idle (SC300)."""


@dataclass(frozen=True)
class Ready:
    """``READY``: the MC600 has taken a motion command and begins."""


@dataclass(frozen=True)
class Refused:
    """``E01``, ``E0``, ``ER``...: the controller's own error. What the codes mean is in no public source."""

    code: str


@dataclass(frozen=True)
class Position:
    """The answer to a position query, in pulses."""

    pulses: float


@dataclass(frozen=True)
class Arrived:
    """A line that nobody asked for: the motion is over, at so many pulses."""

    pulses: float


@dataclass(frozen=True)
class Value:
    """The answer to any other query: ``SETUNIT? X,S,OK`` or ``XV,20000``."""

    subject: str
    text: str


@dataclass(frozen=True)
class Named:
    """The SC300 tells its name: ``SC300_V1.0``, ``SC300``, ``ID0000``."""

    text: str


@dataclass(frozen=True)
class Unknown:
    """A line of no known meaning, or one of another axis. Kept and logged, never taken for data."""

    line: bytes


Event: TypeAlias = Okay | Ready | Refused | Position | Arrived | Value | Named | Unknown


@dataclass(frozen=True)
class Command:
    """Bytes to send, and the kind of event that answers them."""

    data: bytes
    awaits: type[Event] | None
    """None where the controller answers nothing until the motion is over (moves of the SC300)."""


class Codec(Protocol):
    """One dialect: lines in, events out; intents in pulses in, commands out. No I/O, no clock, nothing remembered."""

    @property
    def name(self) -> str:
        """Controller model."""
        ...

    @property
    def answers_in_motion(self) -> bool:
        """Whether a position query is answered while the stage moves."""
        ...

    @property
    def may_end_a_motion(self) -> tuple[type[Event], ...]:
        """Unasked events that may mean that a motion is over. Each is checked by reading the position back."""
        ...

    def classify(self, line: bytes) -> Event:
        """Say what a line, without its CR, means. ``Lines`` cuts the bytes of the port into lines."""
        ...

    def set_up(self) -> tuple[Command, ...]:
        """Give what has to be set once, before anything else: the unit."""
        ...

    def set_velocity(self, pulses_per_s: int) -> Command:
        """Set the cruise velocity of the moves to come."""
        ...

    def set_acceleration(self, pulses_per_s2: int) -> Command:
        """Set the acceleration of both ramps."""
        ...

    def set_initial_velocity(self, pulses_per_s: int) -> Command:
        """Set the velocity that a move starts with."""
        ...

    def set_home_velocity(self, pulses_per_s: int) -> Command | None:
        """Set the velocity of homing; None where homing runs at the velocity of moves."""
        ...

    def move_to(self, target: int, standing_at: int) -> Command:
        """Go to ``target`` pulses."""
        ...

    def move_by(self, distance: int) -> Command:
        """Go ``distance`` pulses further."""
        ...

    def home(self) -> Command:
        """Look for the origin."""
        ...

    def ask_position(self) -> Command:
        """Ask where the stage is."""
        ...

    def stop(self) -> bytes:
        """Stop. What the controller answers is unknown, so nothing waits for it."""
        ...

    def fence(self) -> Command:
        """A harmless query whose answer looks like no other: what came before it belongs to older commands."""
        ...


class Lines:
    """Cuts bytes into lines at CR. The same lines come out, however the bytes are split on their way in."""

    def __init__(self) -> None:
        self._buffer = b""

    @property
    def pending(self) -> bytes:
        """The beginning of a line whose CR has not come yet."""
        return self._buffer

    def feed(self, data: bytes) -> list[bytes]:
        """Give the lines that ``data`` completes, without CR, stray LF and blanks; empty lines are left out."""
        self._buffer += data
        lines: list[bytes] = []
        while (end := self._end()) is not None:
            line, self._buffer = self._buffer[:end], self._buffer[end:].removeprefix(CR)
            if stripped := line.strip():
                lines.append(stripped)
        return lines

    def discard(self) -> bytes:
        """Forget the pending beginning of a line, and give it back for the log."""
        lost, self._buffer = self._buffer, b""
        return lost

    def _end(self) -> int | None:
        end = self._buffer.find(CR, 0, LONGEST_LINE + 1)
        if end >= 0:
            return end
        return LONGEST_LINE if len(self._buffer) > LONGEST_LINE else None
