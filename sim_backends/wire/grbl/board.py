"""The board: real-time bytes, lines, states, motion (sheet, section 3)."""

from collections import deque
from collections.abc import Callable
from typing import TypeAlias

from protocols import Floats
from sim_backends.bench import BenchClock
from sim_backends.wire.grbl.faults import Faults
from sim_backends.wire.grbl.jog import Jog, parse_jog
from sim_backends.wire.grbl.settings import GrblEmulatorSettings, PortVanishes
from sim_backends.wire.serial_box import SerialBox
from sim_backends.wire.stepper.axis import Axis
from sim_backends.wire.stepper.motion import Rates

CarryObject: TypeAlias = Callable[[Callable[[Floats], Floats]], None]
"""Function that is told how the object is carried: clock seconds ``(n,)`` to mm ``(n,)``."""

_LONGEST = 127
_PLANNER = 15
"""Blocks: more jogs than these wait in the receive buffer."""

_UNLOCK = "[MSG:'$H'|'$X' to unlock]"
_WCO_EVERY = 10


class GrblBoard:
    """Takes bytes from ``box`` and answers on it."""

    def __init__(self, settings: GrblEmulatorSettings, clock: BenchClock, carry: CarryObject | None = None) -> None:
        """Switch it on.

        Args:
            settings: mechanics, line and habits.
            clock: the bench's.
            carry: told each time the axis begins to move otherwise.
        """
        self._settings, self._carry = settings, carry
        self.box = SerialBox(clock, settings.baud)
        self.box.take = self._byte
        low, high = (round(end * settings.steps_per_mm) for end in settings.travel_mm)
        self._ends = (low, high)
        self._axis = Axis(low=low, high=high, start=round(settings.start_mm * settings.steps_per_mm))
        self._zero_mm = 0.0
        """What the controller calls the place where its counter is 0."""

        self._faults = Faults(settings.faults)
        self._stored = self._first_settings()
        self._typed = bytearray()
        self._jogs: deque[Jog] = deque()
        self._waiting: deque[str] = deque()
        self._locked, self._silent, self._homed = settings.homing, False, False
        self._homing = False
        self._reports = 0
        self._hears_from_s = clock.now_s()
        self._boot(clock.now_s())
        self._tell_bench()

    def _first_settings(self) -> dict[int, float]:
        settings, index = self._settings, "XYZ".index(self._settings.axis)
        stored: dict[int, float] = {
            10: 1 if settings.report == "MPos" else 0,
            13: settings.inches,
            20: settings.soft_limits,
            21: settings.hard_limits,
            22: settings.homing,
            25: 60 * settings.home_rate_mm_s,
        }
        for axis in range(3):
            stored[100 + axis] = 250.0
            stored[110 + axis] = 500.0
            stored[120 + axis] = 10.0
            stored[130 + axis] = 200.0
        stored[100 + index] = settings.steps_per_mm
        stored[110 + index] = 60 * settings.max_rate_mm_s
        stored[120 + index] = settings.acceleration_mm_s2
        stored[130 + index] = settings.travel_mm[1] - settings.travel_mm[0]
        return stored

    def _tell_bench(self) -> None:
        if self._carry is None:
            return
        path, per_mm = self._axis.carriage, self._settings.steps_per_mm
        self._carry(lambda clock_s: path.at(clock_s) / per_mm)

    # Start and reset

    def _boot(self, now_s: float) -> None:
        self._hears_from_s = now_s + self._settings.boot_s
        self.box.at(self._hears_from_s, self._welcome)

    def _welcome(self, now_s: float) -> None:
        self._say("", "", now_s)
        self._say("", "Grbl 1.1f ['$' for help]", now_s)
        if self._locked:
            self._say("", _UNLOCK, now_s)

    def _reset(self, now_s: float) -> None:
        moved = self._axis.moving(now_s)
        if moved:
            self._say("", f"ALARM:{6 if self._homing else 3}", now_s)
            self._axis.stop(now_s, self._rates(), decelerate=False)
            self._tell_bench()
            self._homed = False
        self._locked = self._locked or moved or self._silent
        self._silent = self._homing = False
        self._typed.clear()
        self._jogs.clear()
        self._waiting.clear()
        self._welcome(now_s)

    # Bytes

    def _byte(self, byte: int, at_s: float) -> None:
        if at_s < self._hears_from_s:
            return
        now_s = at_s + self._settings.turnaround_s
        if byte in b"?!~\x18" or byte >= 0x80:
            self._real_time(byte, now_s)
        elif byte in b"\r\n":
            line, self._typed = bytes(self._typed), bytearray()
            self._line("".join(line.decode("ascii", "replace").split()).upper(), now_s, too_long=len(line) > _LONGEST)
        elif len(self._typed) <= _LONGEST:
            self._typed.append(byte)

    def _struck(self, line: str, now_s: float) -> bool:
        """Whether a fault takes the place of what a line or a byte would do."""
        struck = self._faults.command(line)
        if struck is PortVanishes:
            self.box.vanished = True
        elif struck is not None:
            self._reset(now_s)
        return struck is not None

    def _real_time(self, byte: int, now_s: float) -> None:
        if self._struck(chr(byte), now_s):
            return
        if byte == 0x18:
            self._reset(now_s)
        elif byte == ord("?") and not self._homing and not self._silent:
            self._say("?", self._status(now_s), now_s + self._settings.status_s)
        elif byte in {0x85, ord("!")} and self._axis.moving(now_s) and not self._homing:
            self._jogs.clear()
            self._axis.stop(now_s, self._rates(), decelerate=True)
            self._after_motion()

    def _say(self, asked: str, line: str, at_s: float) -> None:
        data, late_s = self._faults.answer(asked, line.encode() + b"\r\n")
        if late_s:
            self.box.at(at_s + late_s, lambda now_s: self.box.transmit(data, now_s))
        else:
            self.box.transmit(data, at_s)

    def _status(self, now_s: float) -> str:
        moving = self._axis.moving(now_s)
        state = "Alarm" if self._locked else "Jog" if moving else "Idle"
        here, offset = self._mm(now_s), self._settings.work_offset_mm
        shown = here if self._stored[10] else here - offset
        feed = abs(self._axis.counter.speed(now_s)) * 60 / self._settings.steps_per_mm
        fields = [state, f"{'MPos' if self._stored[10] else 'WPos'}:{self._three(shown)}", f"FS:{feed:.0f},0"]
        if self._reports % _WCO_EVERY == 0:
            fields.append(f"WCO:{self._three(offset)}")
        self._reports += 1
        return f"<{'|'.join(fields)}>"

    def _three(self, mm: float) -> str:
        return ",".join(f"{mm if axis == self._settings.axis else 0.0:.3f}" for axis in "XYZ")

    def _mm(self, now_s: float) -> float:
        return self._zero_mm + self._axis.reported(now_s) / self._settings.steps_per_mm

    # Lines

    def _line(self, line: str, now_s: float, *, too_long: bool) -> None:
        if self._struck(line, now_s):
            return
        if self._homing or self._silent or len(self._jogs) >= _PLANNER:
            self._waiting.append(line)
            return
        code = 11 if too_long else self._faults.error(line)
        if code is None:
            code = self._execute(line, now_s)
        if code is not None:
            self._say(line, f"error:{code}" if code else "ok", now_s)

    def _execute(self, line: str, now_s: float) -> int | None:
        """Carry out a line; give the number of its error, 0 for ``ok`` now, None for an answer later."""
        if line.startswith("$J="):
            return self._jog(line[3:], now_s)
        if line and not line.startswith("$"):
            return 9 if self._locked or self._axis.moving(now_s) else 20
        if line == "":
            return 0
        if self._axis.moving(now_s):
            return 8
        name, equals, value = line[1:].partition("=")
        if equals:
            return self._store(name, value)
        answers = {
            "$": [f"${number}={_plain(number, stored)}" for number, stored in sorted(self._stored.items())],
            "I": ["[VER:1.1f.20170801:]", "[OPT:VL,16,128]"],
        }
        if name in answers:
            for answer in answers[name]:
                self._say(line, answer, now_s)
            return 0
        if name == "X":
            if self._locked:
                self._locked = False
                self._say(line, "[MSG:Caution: Unlocked]", now_s)
            return 0
        return self._home(line, now_s) if name == "H" else 3

    def _store(self, name: str, value: str) -> int:
        try:
            number, stored = int(name), float(value)
        except ValueError:
            return 2
        if number not in self._stored:
            return 3
        if stored < 0:
            return 4
        self._stored[number] = stored
        return 0

    # Motion

    def _rates(self, feed_mm_s: float | None = None) -> Rates:
        index, per_mm = "XYZ".index(self._settings.axis), self._settings.steps_per_mm
        highest = self._stored[110 + index] / 60
        return Rates(min(feed_mm_s or highest, highest) * per_mm, 0.0, self._stored[120 + index] * per_mm)

    def _jog(self, text: str, now_s: float) -> int:
        if self._locked:
            return 8
        jog = parse_jog(text)
        if isinstance(jog, int):
            return jog
        if self._stored[20]:
            low, high = (self._settings.home_position_mm + end for end in self._settings.travel_mm)
            if not low <= self._target_mm(jog, self._mm(now_s)) <= high:
                return 15
        self._jogs.append(jog)
        if not self._axis.moving(now_s):
            self._next_jog(now_s)
        return 0

    def _target_mm(self, jog: Jog, here_mm: float) -> float:
        asked = jog.to_mm.get(self._settings.axis)
        if asked is None:
            return here_mm
        if jog.relative:
            return here_mm + asked
        return asked if jog.machine else asked + self._settings.work_offset_mm

    def _next_jog(self, now_s: float) -> None:
        jog = self._jogs.popleft()
        target = round((self._target_mm(jog, self._mm(now_s)) - self._zero_mm) * self._settings.steps_per_mm)
        distance = target - self._axis.reported(now_s)
        if distance:
            self._axis.move(now_s, distance, self._rates(jog.feed_mm_s), self._faults.stalls())
            self._after_motion()
        while self._waiting and len(self._jogs) < _PLANNER and not self._silent:
            self._line(self._waiting.popleft(), now_s, too_long=False)

    def _after_motion(self) -> None:
        motion = self._axis.motion
        self._tell_bench()

        def arrive(now_s: float) -> None:
            if self._axis.motion != motion or self._silent:
                return
            if (
                self._stored[21]
                and self._axis.carriage.now(now_s) in self._ends
                and self._axis.reported(now_s) != self._axis.target
            ):
                self._say("", "ALARM:1", now_s)
                self._say("", "[MSG:Reset to continue]", now_s)
                self._silent, self._homed = True, False
            elif self._jogs:
                self._next_jog(now_s)

        self.box.at(self._axis.end_s, arrive)

    def _home(self, line: str, now_s: float) -> int | None:
        if not self._stored[22]:
            return 5
        self._locked, self._homed, self._homing = True, False, True
        self._axis.home(now_s, self._rates(self._stored[25] / 60), "direct", None)
        motion = self._axis.motion
        self._tell_bench()

        def arrive(end_s: float) -> None:
            if self._axis.motion != motion or not self._homing:
                return
            self._homing = False
            if self._faults.no_switch:
                self._say("", "ALARM:9", end_s)
            else:
                self._zero_mm, self._homed, self._locked = self._settings.home_position_mm, True, False
                self._say(line, "ok", end_s)
            while self._waiting and not self._homing:
                self._line(self._waiting.popleft(), end_s, too_long=False)

        self.box.at(self._axis.end_s, arrive)
        return None


def _plain(number: int, value: float) -> str:
    return f"{value:.3f}" if number >= 25 else f"{value:g}"
