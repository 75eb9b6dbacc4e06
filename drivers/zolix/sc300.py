"""The SC300 dialect: two letters, a comma, a number of pulses (fact sheet of the KA400Z, section 3A).

A move is answered only when it is over, by a line of the same form as a position. Its first byte is in no public source, so
any is taken. No absolute move is known: it is made as a relative one from where the stage stands.
"""

import re
from typing import Final, Literal

from drivers.zolix.events import Arrived, Command, Event, Named, Okay, Position, Refused, Unknown, Value

_ERROR = re.compile(rb"E(?:R|\d)")
_POSITION = re.compile(rb"(.)([XYZ]), *([+-]?\d{1,9})", re.DOTALL)
_SETTING = re.compile(rb"([XYZ][VFA]), *(\d{1,9})")
_NAME = re.compile(rb"SC300[ -~]*|ID\d+")


class Sc300Codec:
    """Bytes and events of one SC300 axis, in pulses."""

    def __init__(self, axis: Literal["X", "Y", "Z"]) -> None:
        self._axis: Final = axis
        self.name: Final = "SC300"
        self.answers_in_motion: Final = False
        self.may_end_a_motion: Final[tuple[type[Event], ...]] = (Arrived, Position, Refused)
        """``Position`` too: the line at the end of a move may begin with ``?`` like the answer to a query."""

    def set_up(self) -> tuple[Command, ...]:
        """Give nothing: an SC300 knows pulses only."""
        return ()

    def set_velocity(self, pulses_per_s: int) -> Command:
        """``VX,20000``."""
        return self._set("V", pulses_per_s)

    def set_acceleration(self, pulses_per_s2: int) -> Command:
        """``AX,30000``."""
        return self._set("A", pulses_per_s2)

    def set_initial_velocity(self, pulses_per_s: int) -> Command:
        """``FX,2500``."""
        return self._set("F", pulses_per_s)

    def set_home_velocity(self, pulses_per_s: int) -> None:  # noqa: ARG002 (the Codec protocol's)
        """Give nothing: no homing velocity of its own is known, so homing is taken to run at the velocity of moves."""
        return

    def move_to(self, target: int, standing_at: int) -> Command:
        """``+X,1000`` from 0: the difference, as a relative move."""
        return self.move_by(target - standing_at)

    def move_by(self, distance: int) -> Command:
        """``+X,1000`` or ``-X,1000``: the number is unsigned. The answer comes at the end of the move."""
        sign = "-" if distance < 0 else "+"
        return Command(f"{sign}{self._axis},{abs(distance)}\r".encode("ascii"), awaits=None)

    def home(self) -> Command:
        """``HX``. The answer comes at the end."""
        return Command(f"H{self._axis}\r".encode("ascii"), awaits=None)

    def ask_position(self) -> Command:
        """``?X``."""
        return Command(f"?{self._axis}\r".encode("ascii"), awaits=Position)

    def stop(self) -> bytes:
        """``SPX``: three letters, from one source; the manual's own pages on it were not available."""
        return f"SP{self._axis}\r".encode("ascii")

    def fence(self) -> Command:
        """``VE``, answered by ``SC300_V1.0``."""
        return Command(b"VE\r", awaits=Named)

    def _set(self, letter: str, value: int) -> Command:
        return Command(f"{letter}{self._axis},{value}\r".encode("ascii"), awaits=Okay)

    def classify(self, line: bytes) -> Event:
        """Say what a line, without its CR, means."""
        if line == b"OK":
            return Okay()
        if _ERROR.fullmatch(line):
            return Refused(line.decode())
        if _NAME.fullmatch(line):
            return Named(line.decode())
        if setting := _SETTING.fullmatch(line):
            return Value(setting[1].decode(), setting[2].decode())
        if (report := _POSITION.fullmatch(line)) and report[2] == self._axis.encode():
            return Position(float(report[3])) if report[1] == b"?" else Arrived(float(report[3]))
        return Unknown(line)
