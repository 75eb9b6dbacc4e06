"""The registers of one MC600 axis: what ``Set...`` writes and ``Set...?`` reads (ka400z.md 3B)."""

import re

from sim_backends.wire.stepper.motion import Rates
from sim_backends.wire.zolix.settings import Mc600Settings

_SIGNED = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)")

_WORDS = {
    "SETUNIT": "MUSD",
    "SETSTAGESTYLE": "TR",
    "SETSTAGEWORKSTATE": "OC",
    "SETORIGIN": "PN",
    "SETSECHHOMEMODE": "12",
    "SETUSERLIMITABLE": "ED",
}
"""Registers that hold one letter, and the letters that they take."""

_RATIOS = {"SETSTAGEPITCH": 1000.0, "SETSTAGESTEPSREV": 1e7, "SETSTAGEDRIVERAT": 1e4}
"""Registers that make pulses from units, and the value below which they must stay (ranges of the ZC300 [I])."""

_RATES = ("SETSPEED", "SETINITSPEED", "SETACCSPEED", "SETHOMESPEED")

_LENGTHS = ("SETSTAGEDISTANCE", "SETOFFSET", "SETUSERPOSITIVELIMIT", "SETUSERNEGATIVELIMIT")


class Registers:
    """Lengths and speeds are kept in pulses, so that a change of unit leaves them what they are."""

    def __init__(self, settings: Mc600Settings) -> None:
        """Take the values that the box has when power comes."""
        self._decimals = settings.decimals
        self._words = {
            "SETUNIT": settings.unit.upper(),
            "SETSTAGESTYLE": "T",
            "SETSTAGEWORKSTATE": "O",
            "SETORIGIN": "P",
            "SETSECHHOMEMODE": "2",
            "SETUSERLIMITABLE": "D",
        }
        self._ratios = {
            "SETSTAGEPITCH": settings.lead_mm,
            "SETSTAGESTEPSREV": 200.0 * settings.microsteps,
            "SETSTAGEDRIVERAT": 1.0,
        }
        low, high = settings.travel_mm
        in_mm = {
            "SETSPEED": settings.speed_mm_s,
            "SETINITSPEED": settings.initial_speed_mm_s,
            "SETACCSPEED": settings.acceleration_mm_s2,
            "SETHOMESPEED": settings.home_speed_mm_s,
            "SETSTAGEDISTANCE": high - low,
            "SETOFFSET": 0.0,
            "SETUSERPOSITIVELIMIT": high,
            "SETUSERNEGATIVELIMIT": low,
        }
        self._pulses = {verb: value * settings.pulses_per_mm for verb, value in in_mm.items()}
        self.user_origin = 0
        """Work origin on the counter."""

    @property
    def pulses_per_unit(self) -> float:
        """Pulses of one mm, um, pulse or degree, by pitch, pulses a turn and gear ratio."""
        turn = self._ratios["SETSTAGESTEPSREV"] * self._ratios["SETSTAGEDRIVERAT"]
        pitch = self._ratios["SETSTAGEPITCH"]
        return {"M": turn / pitch, "U": turn / pitch / 1000, "S": 1.0, "D": turn / 360}[self._words["SETUNIT"]]

    @property
    def zero(self) -> int:
        """Counter value that is called 0: the physical zero, or the work origin in zero mode N."""
        return self.user_origin if self._words["SETORIGIN"] == "N" else 0

    @property
    def rates(self) -> Rates:
        """For a move."""
        return Rates(*(self._pulses[verb] for verb in _RATES[:3]))

    @property
    def home_rates(self) -> Rates:
        """For homing."""
        home, initial = self._pulses["SETHOMESPEED"], self._pulses["SETINITSPEED"]
        return Rates(home, min(home, initial), self._pulses["SETACCSPEED"])

    def inside_soft_limits(self, target: int) -> int:
        """Give the nearest allowed counter value."""
        if self._words["SETUSERLIMITABLE"] == "D":
            return target
        low = self.zero + round(self._pulses["SETUSERNEGATIVELIMIT"])
        high = self.zero + round(self._pulses["SETUSERPOSITIVELIMIT"])
        return min(max(target, low), high)

    def text(self, pulses: float) -> str:
        """Pulses as a number in the present unit."""
        decimals = self._decimals if self._words["SETUNIT"] in "MD" else 1
        return f"{pulses / self.pulses_per_unit:.{decimals}f}"

    def read(self, verb: str) -> str | None:
        """Value of a register, or None where there is no such register."""
        if verb in self._words:
            return self._words[verb]
        if verb in self._ratios:
            return f"{self._ratios[verb]:g}"
        return self.text(self._pulses[verb]) if verb in self._pulses else None

    def write(self, verb: str, value: str) -> bool:
        """Set a register; False where there is no such register, or it does not take the value."""
        if verb in _WORDS:
            if len(value) != 1 or value not in _WORDS[verb]:
                return False
            self._words[verb] = value
            return True
        if not _SIGNED.fullmatch(value):
            return False
        number = float(value)
        if verb in _RATIOS and 0 < number < _RATIOS[verb]:
            self._ratios[verb] = number
            return True
        # An initial speed of 0 is a plain ramp from standstill; no other rate may be 0.
        positive = number > 0 or (verb == "SETINITSPEED" and number == 0)
        if (verb in _RATES and positive) or verb in _LENGTHS:
            self._pulses[verb] = number * self.pulses_per_unit
            return True
        return False
