"""The MC600's verbs (ka400z.md 3B)."""

import re
from collections.abc import Callable

from sim_backends.bench import BenchClock
from sim_backends.wire.stepper.axis import Axis
from sim_backends.wire.stepper.motion import Rates
from sim_backends.wire.zolix.controller import Answer, CarryObject, EmulatedController
from sim_backends.wire.zolix.faults import Faults
from sim_backends.wire.zolix.registers import Registers
from sim_backends.wire.zolix.settings import Mc600Settings

_AXES = "XYZT"

_NUMBER = re.compile(r"\d+(\.\d*)?|\.\d+")

_SIGNED = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)")

_LINE = re.compile(r"([A-Z0-9]+\??)(?: +(.*))?")


class _NotUnderstoodError(Exception):
    """The command is answered with the syntax error."""


class Mc600:
    """Meaning of the lines: ``Verb<space>Axis[,arg...]``, in upper or lower case; a query is the verb and ``?``."""

    def __init__(self, settings: Mc600Settings, axes: dict[str, Axis], faults: Faults) -> None:
        """Load the registers that the box has when power comes."""
        self._settings = settings
        self._axes = axes
        self._faults = faults
        self._registers = {axis: Registers(settings) for axis in axes}
        self._verbs: dict[str, Callable[[list[str], float], Answer]] = {
            "HELLO": lambda _arguments, _now_s: Answer(("OK",)),
            "LOADDEFAULT": self._load_default,
            "POSITION?": self._position,
            "GOPOSITION": self._go_position,
            "GOHOME": lambda arguments, now_s: self._home(self._axis(arguments), now_s),
            "GONAXISHOME": self._home_several,
            "GOORIGION": self._go_origin,
            "STOP": self._stop,
            "SETUSERORIGIN": self._set_user_origin,
            "SETUSERORIGIN?": self._user_origin,
            "GOINTERPOLATIONLINE2": lambda arguments, now_s: self._go_line(arguments, 2, now_s),
            "GOINTERPOLATIONLINE3": lambda arguments, now_s: self._go_line(arguments, 3, now_s),
        }

    @property
    def bad_line(self) -> str:
        """See ``Dialect``."""
        return self._settings.error_syntax

    def is_stop(self, command: str) -> bool:
        """See ``Dialect``."""
        return command.strip().upper().startswith("STOP")

    def completion(self, axis: str, now_s: float) -> str:
        """``X 1000.0,OK``: no question mark."""
        return self._settings.completion.format(axis=axis, position=self._reported(axis, now_s))

    def _reported(self, axis: str, now_s: float) -> str:
        registers = self._registers[axis]
        return registers.text(self._axes[axis].reported(now_s) - registers.zero)

    def execute(self, command: str, now_s: float) -> Answer:
        """See ``Dialect``. A lone CR is passed over."""
        text = command.strip().upper()
        if not text:
            return Answer()
        try:
            match = _LINE.fullmatch(text)
            if match is None:
                raise _NotUnderstoodError
            verb, arguments = match[1], (match[2] or "").split(",")
            if verb in self._verbs:
                return self._verbs[verb](arguments, now_s)
            return self._register(verb, arguments, now_s)
        except _NotUnderstoodError:
            return Answer((self._settings.error_syntax,))

    def _axis(self, arguments: list[str], count: int = 1) -> str:
        if len(arguments) != count or arguments[0] not in self._axes:
            raise _NotUnderstoodError
        return arguments[0]

    def _refused(self) -> Answer:
        return Answer((self._settings.error_refused,))

    def _register(self, verb: str, arguments: list[str], now_s: float) -> Answer:
        """``SetSpeed? X`` and ``SetSpeed X,960``."""
        if verb.endswith("?"):
            axis = self._axis(arguments)
            value = self._registers[axis].read(verb[:-1])
            if value is None:
                raise _NotUnderstoodError
            return Answer((f"{verb} {axis},{value},OK",))
        axis = self._axis(arguments, 2)
        if self._axes[axis].moving(now_s):
            return self._refused()
        if not self._registers[axis].write(verb, arguments[1]):
            raise _NotUnderstoodError
        return Answer(("OK",), stored=True)

    def _load_default(self, _arguments: list[str], now_s: float) -> Answer:
        if any(axis.moving(now_s) for axis in self._axes.values()):
            return self._refused()
        self._registers = {axis: Registers(self._settings) for axis in self._axes}
        return Answer(("OK",), stored=True)

    def _position(self, arguments: list[str], now_s: float) -> Answer:
        axis = self._axis(arguments)
        return Answer((f"POSITION? {axis},{self._reported(axis, now_s)},OK",))

    def _go_position(self, arguments: list[str], now_s: float) -> Answer:
        """``GoPosition X,O,R,P,1000``: axis, loop, relative or absolute, sign, unsigned number."""
        axis = self._axis(arguments, 5)
        _, loop, kind, sign, number = arguments
        if loop not in ("O", "C") or kind not in ("R", "A") or sign not in ("P", "N") or not _NUMBER.fullmatch(number):
            raise _NotUnderstoodError
        registers = self._registers[axis]
        pulses = round(float(number) * registers.pulses_per_unit) * (1 if sign == "P" else -1)
        here = self._axes[axis].reported(now_s)
        return self._move(axis, here + pulses if kind == "R" else registers.zero + pulses, now_s)

    def _go_origin(self, arguments: list[str], now_s: float) -> Answer:
        """``GoOrigion X``: to the work origin, spelled so."""
        axis = self._axis(arguments)
        return self._move(axis, self._registers[axis].user_origin, now_s)

    def _move(self, axis: str, target: int, now_s: float) -> Answer:
        motor, registers = self._axes[axis], self._registers[axis]
        allowed = registers.inside_soft_limits(target)
        if motor.moving(now_s) or (allowed != target and self._settings.soft_limit == "refuse"):
            return self._refused()
        distance = allowed - motor.reported(now_s)
        if motor.blocked(now_s, distance):
            return self._refused()
        if distance:
            motor.move(now_s, distance, registers.rates, self._faults.move())
        else:
            motor.stand(now_s)
        return Answer(("READY",), moved=(axis,))

    def _go_line(self, arguments: list[str], n: int, now_s: float) -> Answer:
        """``GoInterpolationline2 X,1.0,Y,2.0``: axes that arrive together. Absolute, signed targets [I]."""
        if len(arguments) != 2 * n or len(set(arguments[::2])) < n or not set(arguments[::2]) <= self._axes.keys():
            raise _NotUnderstoodError
        if not all(_SIGNED.fullmatch(number) for number in arguments[1::2]):
            raise _NotUnderstoodError
        ways: dict[str, int] = {}
        for axis, number in zip(arguments[::2], arguments[1::2], strict=True):
            motor, registers = self._axes[axis], self._registers[axis]
            target = registers.zero + round(float(number) * registers.pulses_per_unit)
            ways[axis] = target - motor.reported(now_s)
            soft = registers.inside_soft_limits(target) != target
            if motor.moving(now_s) or motor.blocked(now_s, ways[axis]) or soft:
                return self._refused()
        longest = max(ways, key=lambda axis: abs(ways[axis]))
        rates = self._registers[longest].rates
        for axis, way in ways.items():
            if way == 0:
                self._axes[axis].stand(now_s)
                continue
            share = abs(way / ways[longest])
            self._axes[axis].move(now_s, way, rates.scaled(share), self._faults.move())
        return Answer(("READY",), moved=tuple(ways))

    def _home(self, axis: str, now_s: float) -> Answer:
        motor, settings = self._axes[axis], self._settings
        if motor.moving(now_s):
            return self._refused()
        motor.home(now_s, self._registers[axis].home_rates, settings.homing, settings.homing_s)
        return Answer(("READY",), moved=(axis,))

    def _home_several(self, arguments: list[str], now_s: float) -> Answer:
        """``GonAxisHome Y,N,N,N``: yes or no for each of X, Y, Z, T."""
        if len(arguments) != len(_AXES) or not set(arguments) <= {"Y", "N"}:
            raise _NotUnderstoodError
        chosen = [axis for axis, yes in zip(_AXES, arguments, strict=True) if yes == "Y"]
        if any(self._axes[axis].moving(now_s) for axis in chosen):
            return self._refused()
        for axis in chosen:
            self._home(axis, now_s)
        return Answer(("READY",), moved=tuple(chosen))

    def _stop(self, arguments: list[str], now_s: float) -> Answer:
        axis, settings = self._axis(arguments), self._settings
        motor = self._axes[axis]
        replies = (settings.stop_reply,) if settings.stop_reply else ()
        if not motor.moving(now_s):
            return Answer(replies)
        rates: Rates = self._registers[axis].rates
        motor.stop(now_s, rates, decelerate=settings.stop_ramp == "decelerate")
        return Answer(replies, moved=(axis,), completes=settings.stop_completion)

    def _user_origin(self, arguments: list[str], _now_s: float) -> Answer:
        """``SetUserOrigin? X``: where the work origin is, in the present unit."""
        axis = self._axis(arguments)
        return Answer((f"SETUSERORIGIN? {axis},{self._registers[axis].text(self._registers[axis].user_origin)},OK",))

    def _set_user_origin(self, arguments: list[str], now_s: float) -> Answer:
        """``SetUserOrigin X,0``: the work origin is here."""
        axis = self._axis(arguments, 2)
        if arguments[1] != "0":
            raise _NotUnderstoodError
        if self._axes[axis].moving(now_s):
            return self._refused()
        self._registers[axis].user_origin = self._axes[axis].reported(now_s)
        return Answer(("OK",), stored=True)


def mc600_controller(
    settings: Mc600Settings, clock: BenchClock, carry: CarryObject | None = None
) -> EmulatedController:
    """Switch an MC600 on. It has four axes with the same mechanics; one carries the object."""
    return EmulatedController(settings, clock, lambda axes, faults: Mc600(settings, axes, faults), carry, _AXES)
