"""One Zaber device with one axis: commands, replies, flags, motion (sheet, sections 2 and 5)."""

from collections.abc import Callable
from typing import TypeAlias

from protocols import Floats
from sim_backends.bench import BenchClock
from sim_backends.wire.serial_box import SerialBox
from sim_backends.wire.stepper.axis import Axis
from sim_backends.wire.stepper.motion import Rates
from sim_backends.wire.zaber.faults import Faults
from sim_backends.wire.zaber.packets import LONGEST, Command, lrc, understand
from sim_backends.wire.zaber.settings import ZaberEmulatorSettings

CarryObject: TypeAlias = Callable[[Callable[[Floats], Floats]], None]
"""Function that is told how the object is carried: clock seconds ``(n,)`` to mm ``(n,)``."""

_ORDER = "FWN"
"""Priority of flags: faults, warnings, notes."""


class ZaberDevice:
    """Takes bytes from ``box`` and answers on it."""

    def __init__(self, settings: ZaberEmulatorSettings, clock: BenchClock, carry: CarryObject | None = None) -> None:
        """Switch it on.

        Args:
            settings: mechanics, line and habits.
            clock: the bench's.
            carry: told each time the axis begins to move otherwise.
        """
        self._settings = settings
        self._carry = carry
        self.box = SerialBox(clock, settings.baud)
        self.box.take = self._byte
        low, high = (round(end * settings.microsteps_per_mm) for end in settings.travel_mm)
        self._limits = (low, high)
        start = round(settings.start_mm * settings.microsteps_per_mm)
        self._axis = Axis(low=low, high=high, start=start)
        self._referenced = settings.referenced
        self._flags: set[str] = set() if settings.driver_enabled else {"FO"}
        self._speed = round(settings.velocity_mm_s * settings.microsteps_per_mm * settings.speed_factor)
        self._accel = round(settings.acceleration_mm_s2 * settings.microsteps_per_mm * settings.acceleration_factor)
        self._stalls_s: float | None = None
        self._faults = Faults(settings.faults)
        self._typed = ""
        self._tell_bench()

    def _tell_bench(self) -> None:
        if self._carry is None:
            return
        path, per_mm = self._axis.carriage, self._settings.microsteps_per_mm
        self._carry(lambda clock_s: path.at(clock_s) / per_mm)

    # Packets

    def _byte(self, byte: int, at_s: float) -> None:
        if byte not in b"\r\n":
            self._typed = (self._typed + chr(byte))[: LONGEST + 1]
            return
        line, self._typed = self._typed, ""
        command = understand(line)
        if command is None or command.device not in (0, self._settings.device):
            return
        if not self._faults.command(command.words):
            self.box.vanished = True
            return
        now_s = at_s + self._settings.turnaround_s
        self._notice_stall(now_s)
        reason = self._faults.rejects(command.words)
        accepted, data = (False, reason) if reason else self._execute(command, now_s)
        self._reply(command, now_s, accepted=accepted, data=data)

    def _reply(self, command: Command, now_s: float, *, accepted: bool, data: str) -> None:
        settings = self._settings
        message_id = "" if command.message_id is None else f" {command.message_id:02d}"
        state = f"{'BUSY' if self._axis.moving(now_s) else 'IDLE'} {self._flag()}"
        text = f"{settings.device:02d} {command.axis}{message_id} {'OK' if accepted else 'RJ'} {state} {data}"
        summed = settings.checksums == "always" or (settings.checksums == "as asked" and command.checked)
        line = f"@{text}{':' + lrc(text) if summed else ''}\r\n"
        alert = f"!{settings.device:02d} 1 {state}\r\n#{settings.device:02d} 0 an info\r\n"
        self.box.transmit(self._faults.reply(command.words, line.encode(), alert.encode()), now_s)

    def _flag(self) -> str:
        return min(self._shown_flags(), key=lambda flag: (_ORDER.index(flag[0]), flag), default="--")

    def _shown_flags(self) -> set[str]:
        return self._flags if self._referenced else self._flags | {"WR"}

    def _notice_stall(self, now_s: float) -> None:
        if self._stalls_s is not None and now_s >= self._stalls_s:
            self._flags.add("FS")
            self._stalls_s = None

    # Commands

    def _execute(self, command: Command, now_s: float) -> tuple[bool, str]:
        """Carry out a command; give whether it is accepted, and the data of the reply."""
        match command.words.split():
            case []:
                return True, "0"
            case ["get", setting]:
                return self._get(setting, now_s)
            case ["set", ("maxspeed" | "accel") as setting, value]:
                return self._set(setting, value)
            case ["tools", "echo", *words]:
                return True, " ".join(words) or "0"
            case ["warnings"]:
                flags = sorted(self._shown_flags())
                return True, " ".join([f"{len(flags):02d}", *flags])
            case ["warnings", "clear"]:
                self._flags = {flag for flag in self._flags if flag == "FO"}
                return True, "0"
            case ["driver", "enable" | "disable" as what]:
                self._flags = self._flags - {"FO"} if what == "enable" else self._flags | {"FO"}
                return True, "0"
            case ["stop" | "estop" as how]:
                return self._stop(now_s, decelerate=how == "stop")
            case ["home"]:
                return self._home(now_s)
            case ["move", *words]:
                return self._move(words, now_s)
            case _:
                return False, "BADCOMMAND"

    def _get(self, setting: str, now_s: float) -> tuple[bool, str]:
        low, high = self._limits
        values: dict[str, object] = {
            "pos": self._axis.reported(now_s),
            "limit.min": low,
            "limit.max": high,
            "limit.home.triggered": int(self._referenced),
            "maxspeed": self._speed,
            "accel": self._accel,
            "system.axiscount": 1,
            "deviceid": 50081,
            "version": "7.34",
            "system.serial": 12345,
        }
        return (True, str(values[setting])) if setting in values else (False, "BADCOMMAND")

    def _set(self, setting: str, value: str) -> tuple[bool, str]:
        settings = self._settings
        highest = settings.max_velocity_mm_s * settings.microsteps_per_mm * settings.speed_factor
        if not value.isdigit() or not 0 < int(value) <= (highest if setting == "maxspeed" else 2**31 - 1):
            return False, "BADDATA"
        if setting == "maxspeed":
            self._speed = int(value)
        else:
            self._accel = int(value)
        return True, "0"

    def _may_move(self) -> str | None:
        if self._settings.parked:
            return "PARKED"
        return "DRIVERDISABLED" if "FO" in self._flags else None

    def _rates(self) -> Rates:
        settings = self._settings
        return Rates(self._speed / settings.speed_factor, 0.0, self._accel / settings.acceleration_factor)

    def _move(self, words: list[str], now_s: float) -> tuple[bool, str]:
        low, high = self._limits
        here = self._axis.reported(now_s)
        match words:
            case ["abs", number] if number.lstrip("-").isdigit():
                target = int(number)
            case ["rel", number] if number.lstrip("-").isdigit():
                target = here + int(number)
            case ["max" | "min" as end]:
                target = high if end == "max" else low
            case _:
                return False, "BADDATA"
        if not low <= target <= high:
            return False, "BADDATA"
        if reason := self._may_move():
            return False, reason
        self._flags -= {"NI", "FS"}
        if self._axis.moving(now_s):  # a new move takes the place of the old one
            self._axis.stop(now_s, self._rates(), decelerate=False)
            self._flags.add("NI")
            here = self._axis.reported(now_s)
        if target == here:
            return True, "0"
        stall_at, rates = self._faults.stalls(), self._rates()
        if stall_at is None:
            self._axis.move(now_s, target - here, rates)
        else:
            self._axis.move(now_s, round((target - here) * stall_at), rates)
            self._stalls_s = self._axis.end_s
        self._tell_bench()
        return True, "0"

    def _home(self, now_s: float) -> tuple[bool, str]:
        if reason := self._may_move():
            return False, reason
        if self._axis.moving(now_s):
            self._axis.stop(now_s, self._rates(), decelerate=False)
        self._flags -= {"NI", "FS"}
        self._referenced = False
        self._axis.home(now_s, self._rates(), "direct", None)
        motion = self._axis.motion

        def arrive(_now_s: float) -> None:
            if self._axis.motion == motion:  # no stop came between
                self._referenced = True

        self.box.at(self._axis.end_s, arrive)
        self._tell_bench()
        return True, "0"

    def _stop(self, now_s: float, *, decelerate: bool) -> tuple[bool, str]:
        if self._axis.moving(now_s):
            self._axis.stop(now_s, self._rates(), decelerate=decelerate)
            self._flags.add("NI")
            self._stalls_s = None
            self._tell_bench()
        return True, "0"
