"""The MC600 dialect: ``Verb Axis[,argument...]`` (fact sheet of the KA400Z, section 3B).

The axis is run in pulses (unit ``s``), so that the conversion to millimetres stands in one place for both dialects and
does not depend on the lead that somebody once stored in the controller. Production code in the field does the same.
"""

import re
from typing import Final, Literal

from drivers.zolix.events import Arrived, Command, Event, Okay, Position, Ready, Refused, Unknown, Value

_ERROR = re.compile(rb"E\d{1,3}")
_ANSWER = re.compile(rb"([A-Z0-9]+)\? ([XYZT]),([^,]*),OK", re.IGNORECASE)
_ARRIVAL = re.compile(rb"([XYZT]) ([+-]?\d{1,9}(?:\.\d{1,9})?),OK", re.IGNORECASE)
_NUMBER = re.compile(rb"[+-]?\d{1,9}(?:\.\d{1,9})?")


class Mc600Codec:
    """Bytes and events of one MC600 axis, in pulses."""

    def __init__(self, axis: Literal["X", "Y", "Z", "T"]) -> None:
        self._axis: Final = axis
        self.name: Final = "MC600"
        self.answers_in_motion: Final = True
        self.may_end_a_motion: Final[tuple[type[Event], ...]] = (Arrived, Refused, Okay)
        """``OK`` too: the sheet has only "a line with OK" at the end of homing."""

    def set_up(self) -> tuple[Command, ...]:
        """Set the unit to pulses."""
        return (self._set("SetUnit", "s"),)

    def set_velocity(self, pulses_per_s: int) -> Command:
        """``SetSpeed X,960``."""
        return self._set("SetSpeed", str(pulses_per_s))

    def set_acceleration(self, pulses_per_s2: int) -> Command:
        """``SetAccSpeed X,12000``."""
        return self._set("SetAccSpeed", str(pulses_per_s2))

    def set_initial_velocity(self, pulses_per_s: int) -> Command:
        """``SetInitSpeed X,800``."""
        return self._set("SetInitSpeed", str(pulses_per_s))

    def set_home_velocity(self, pulses_per_s: int) -> Command:
        """``SetHomeSpeed X,800``."""
        return self._set("SetHomeSpeed", str(pulses_per_s))

    def move_to(self, target: int, standing_at: int) -> Command:  # noqa: ARG002 (the controller knows where it stands)
        """``GoPosition X,O,A,P,1000``: open loop, absolute; P or N carries the sign."""
        return self._go("A", target)

    def move_by(self, distance: int) -> Command:
        """``GoPosition X,O,R,P,1000``: open loop, relative; P or N carries the sign."""
        return self._go("R", distance)

    def home(self) -> Command:
        """``GoHome X``."""
        return Command(self._line("GoHome"), awaits=Ready)

    def ask_position(self) -> Command:
        """``Position? X``."""
        return Command(self._line("Position?"), awaits=Position)

    def stop(self) -> bytes:
        """``Stop X``."""
        return self._line("Stop")

    def fence(self) -> Command:
        """``SetUnit? X``, answered by ``SETUNIT? X,<unit>,OK``."""
        return Command(self._line("SetUnit?"), awaits=Value)

    def _line(self, verb: str, *arguments: str) -> bytes:
        return f"{verb} {','.join((self._axis, *arguments))}\r".encode("ascii")

    def _set(self, verb: str, value: str) -> Command:
        return Command(self._line(verb, value), awaits=Okay)

    def _go(self, kind: Literal["A", "R"], pulses: int) -> Command:
        sign = "N" if pulses < 0 else "P"
        return Command(self._line("GoPosition", "O", kind, sign, str(abs(pulses))), awaits=Ready)

    def classify(self, line: bytes) -> Event:
        """Say what a line, without its CR, means."""
        match line.upper():
            case b"OK":
                return Okay()
            case b"READY":
                return Ready()
            case upper if _ERROR.fullmatch(upper):
                return Refused(upper.decode())
            case _:
                return self._data(line)

    def _data(self, line: bytes) -> Event:
        ours = self._axis.encode()
        if (arrival := _ARRIVAL.fullmatch(line)) and arrival[1].upper() == ours:
            return Arrived(float(arrival[2]))
        if (answer := _ANSWER.fullmatch(line)) and answer[2].upper() == ours:
            verb, value = answer[1].upper(), answer[3]
            if verb != b"POSITION":
                return Value(verb.decode(), value.decode("ascii", "backslashreplace"))
            if _NUMBER.fullmatch(value):
                return Position(float(value))
        return Unknown(line)
