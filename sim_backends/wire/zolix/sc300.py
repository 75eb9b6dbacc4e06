"""The SC300's two-letter commands (ka400z.md 3A)."""

import re

from sim_backends.bench import BenchClock
from sim_backends.wire.stepper.axis import Axis
from sim_backends.wire.stepper.motion import Rates
from sim_backends.wire.zolix.controller import Answer, CarryObject, EmulatedController
from sim_backends.wire.zolix.faults import Faults
from sim_backends.wire.zolix.settings import Sc300Settings

_LARGEST = 9_999_999
"""Seven digits on the display [I]."""

_UNSIGNED = re.compile(r"\d{1,7}")


class Sc300:
    """Meaning of the lines. Everything is in pulses; a command is two characters, ``,`` and an unsigned number."""

    def __init__(self, settings: Sc300Settings, axes: dict[str, Axis], faults: Faults) -> None:
        """Take the speeds that the box has when power comes."""
        self._settings = settings
        self._axes = axes
        self._faults = faults
        registers = {"V": settings.speed_pps, "F": settings.initial_speed_pps, "A": settings.acceleration_pps2}
        self._registers = {axis: dict(registers) for axis in axes}
        self._last = dict.fromkeys(axes, "?")

    @property
    def bad_line(self) -> str:
        """See ``Dialect``."""
        return self._settings.error_command

    def is_stop(self, command: str) -> bool:
        """See ``Dialect``."""
        return command[:2] == "SP"

    def completion(self, axis: str, now_s: float) -> str:
        """``?X,1000``; its first byte on a real box is unknown."""
        first = "?" if self._settings.completion_first == "?" else self._last[axis]
        return f"{first}{axis},{self._axes[axis].reported(now_s)}"

    def execute(self, command: str, now_s: float) -> Answer:
        """See ``Dialect``. The dialect has no case folding."""
        fixed = {"VE": self._settings.version, "TY": "SC300", "ID": "ID0000"}
        if command in fixed:
            return Answer((fixed[command],))
        if command == "":
            idle = not any(axis.moving(now_s) for axis in self._axes.values())
            return Answer(("OK",) if idle else ())
        name, comma, parameter = command.partition(",")
        if len(name) == 3 and name[:2] == "SP" and name[2] in self._axes and not comma:
            return self._stop(name[2], now_s)
        if len(name) != 2:
            return Answer((self._settings.error_command,))
        return self._two_letters(name, parameter, now_s) if comma else self._query(name, now_s)

    def _query(self, name: str, now_s: float) -> Answer:
        letter, axis = name[0], name[1]
        if letter == "?" and axis in self._axes:
            return Answer((f"?{axis},{self._axes[axis].reported(now_s)}",))
        if letter == "H" and axis in self._axes:
            return self._home(axis, now_s)
        axis, letter = name[0], name[1]
        if axis in self._axes and letter in self._registers[axis]:
            return Answer((f"{name},{self._registers[axis][letter]}",))
        return Answer((self._settings.error_command,))

    def _two_letters(self, name: str, parameter: str, now_s: float) -> Answer:
        letter, axis = name[0], name[1]
        if axis not in self._axes or letter not in "VFA+-":
            return Answer((self._settings.error_command,))
        if not _UNSIGNED.fullmatch(parameter):
            return Answer((self._settings.error_parameter,))
        value = int(parameter)
        if letter in "+-":
            return self._move(letter, axis, value, now_s)
        if value == 0 and not (letter == "F" and self._settings.zero_initial_speed):
            return Answer((self._settings.error_parameter,))
        if self._axes[axis].moving(now_s):
            return Answer((self._settings.error_refused,))
        self._registers[axis][letter] = value
        return Answer(("OK",), stored=True)

    def _move(self, letter: str, axis: str, pulses: int, now_s: float) -> Answer:
        motor, distance = self._axes[axis], pulses if letter == "+" else -pulses
        beyond = abs(motor.reported(now_s) + distance) > _LARGEST
        if motor.moving(now_s) or beyond or motor.blocked(now_s, distance):
            return Answer((self._settings.error_refused,))
        self._last[axis] = letter
        if distance == 0:
            return Answer((self.completion(axis, now_s),) if self._settings.zero_move_completes else ())
        motor.move(now_s, distance, self._rates(axis), self._faults.move())
        return Answer(moved=(axis,))

    def _rates(self, axis: str) -> Rates:
        registers = self._registers[axis]
        return Rates(registers["V"], registers["F"], registers["A"])

    def _home(self, axis: str, now_s: float) -> Answer:
        motor, settings = self._axes[axis], self._settings
        if motor.moving(now_s):
            return Answer((settings.error_refused,))
        self._last[axis] = "H"
        registers = self._registers[axis]
        rates = Rates(settings.home_speed_pps, min(registers["F"], settings.home_speed_pps), registers["A"])
        motor.home(now_s, rates, settings.homing, settings.homing_s)
        return Answer(moved=(axis,))

    def _stop(self, axis: str, now_s: float) -> Answer:
        motor, settings = self._axes[axis], self._settings
        replies = (settings.stop_reply,) if settings.stop_reply else ()
        if not motor.moving(now_s):
            return Answer(replies or (f"?{axis},{motor.reported(now_s)}",))
        motor.stop(now_s, self._rates(axis), decelerate=settings.stop_ramp == "decelerate")
        return Answer(replies, moved=(axis,), completes=settings.stop_completion)


def sc300_controller(
    settings: Sc300Settings, clock: BenchClock, carry: CarryObject | None = None
) -> EmulatedController:
    """Switch an SC300 on."""
    return EmulatedController(settings, clock, lambda axes, faults: Sc300(settings, axes, faults), carry, settings.axes)
