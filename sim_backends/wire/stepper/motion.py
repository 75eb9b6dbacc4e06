"""How a stepper moves: ramps, cruise, braking, and a path made of them (ka400z.md 5.1). Lengths in pulses."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from protocols import Floats


class Curve(Protocol):
    """One motion from its own start."""

    @property
    def duration_s(self) -> float:
        """Time from start to standstill."""
        ...

    def travelled(self, time_s: Floats) -> Floats:
        """Give the signed distance covered at ``time_s`` (n,) after the start, inside the motion or not."""
        ...

    def speed(self, time_s: float) -> float:
        """Signed speed at a moment inside the motion."""
        ...


@dataclass(frozen=True)
class Rates:
    """What a controller is told about a motion, in pulses and seconds."""

    top: float
    """Speed between the ramps."""

    initial: float
    """Speed at which a stepper starts and ends without a ramp."""

    acceleration: float
    """Acceleration of both ramps; that they are equal is not known [U]."""

    def scaled(self, share: float) -> "Rates":
        """Give the rates at which a share of a distance takes the same time as the whole at these."""
        return Rates(share * self.top, share * self.initial, share * self.acceleration)


@dataclass(frozen=True)
class Trapezoid:
    """Ramp, cruise and equal ramp down; a triangle where the distance is too short."""

    distance: float
    rates: Rates

    @property
    def _start(self) -> float:
        return min(self.rates.initial, self.rates.top)

    @property
    def _peak(self) -> float:
        reach = math.sqrt(self.rates.acceleration * abs(self.distance) + self._start**2)
        return min(reach, self.rates.top)

    @property
    def _ramp_s(self) -> float:
        return (self._peak - self._start) / self.rates.acceleration

    @property
    def duration_s(self) -> float:
        """T = 2 t_r + (d - 2 s_r) / v, or 2 (v_p - v_0) / a for the triangle."""
        ramps = (self._peak**2 - self._start**2) / self.rates.acceleration
        return 2 * self._ramp_s + max(0.0, abs(self.distance) - ramps) / self._peak

    def travelled(self, time_s: Floats) -> Floats:
        """See ``Curve``."""
        a, v0, total = self.rates.acceleration, self._start, self.duration_s
        t = np.clip(time_s, 0.0, total)
        rest = total - t
        up = v0 * t + a * t * t / 2
        cruise = v0 * self._ramp_s + a * self._ramp_s**2 / 2 + self._peak * (t - self._ramp_s)
        down = abs(self.distance) - (v0 * rest + a * rest * rest / 2)
        done: Floats = np.where(t <= self._ramp_s, up, np.where(rest <= self._ramp_s, down, cruise))
        return math.copysign(1.0, self.distance) * done

    def speed(self, time_s: float) -> float:
        """See ``Curve``."""
        ramp = min(time_s, self.duration_s - time_s)
        return math.copysign(min(self._peak, self._start + self.rates.acceleration * ramp), self.distance)


@dataclass(frozen=True)
class Braking:
    """From a speed down to standstill."""

    from_speed: float
    rates: Rates

    @property
    def duration_s(self) -> float:
        """Time of the ramp down to the initial speed, from which a stepper stands at once."""
        return max(0.0, abs(self.from_speed) - self.rates.initial) / self.rates.acceleration

    def travelled(self, time_s: Floats) -> Floats:
        """See ``Curve``."""
        t = np.clip(time_s, 0.0, self.duration_s)
        return math.copysign(1.0, self.from_speed) * (abs(self.from_speed) * t - self.rates.acceleration * t * t / 2)

    def speed(self, time_s: float) -> float:
        """See ``Curve``."""
        return math.copysign(abs(self.from_speed) - self.rates.acceleration * time_s, self.from_speed)


@dataclass(frozen=True)
class Cut:
    """A motion that ends abruptly: at a limit switch, by an emergency stop, or because the motor has lost its steps."""

    curve: Curve
    duration_s: float

    def travelled(self, time_s: Floats) -> Floats:
        """See ``Curve``."""
        return self.curve.travelled(np.minimum(time_s, self.duration_s))

    def speed(self, time_s: float) -> float:
        """See ``Curve``."""
        return self.curve.speed(time_s)


@dataclass(frozen=True)
class Slack:
    """What a nut with play makes of its screw's motion: it stays behind until the play is taken up."""

    curve: Curve
    play: float
    """Distance that the screw turns before the nut follows."""

    @property
    def duration_s(self) -> float:
        """Time of the screw's motion."""
        return self.curve.duration_s

    def travelled(self, time_s: Floats) -> Floats:
        """See ``Curve``."""
        screw = self.curve.travelled(time_s)
        return np.sign(screw) * np.maximum(np.abs(screw) - self.play, 0.0)

    def speed(self, time_s: float) -> float:
        """See ``Curve``."""
        taken_up = abs(float(self.curve.travelled(np.array([time_s]))[0])) > self.play
        return self.curve.speed(time_s) if taken_up else 0.0


def cut_at(curve: Curve, distance: float) -> Curve:
    """End a motion where it has covered ``distance`` pulses (unsigned), or leave it as it is where it ends before."""
    if abs(float(curve.travelled(np.array([curve.duration_s]))[0])) <= distance:
        return curve
    before, after = 0.0, curve.duration_s
    for _ in range(60):
        middle = (before + after) / 2
        gone = abs(float(curve.travelled(np.array([middle]))[0])) > distance
        before, after = (before, middle) if gone else (middle, after)
    return Cut(curve, before)


@dataclass(frozen=True)
class Leg:
    """A motion on the clock; without a curve, a place."""

    start_s: float
    start: float
    curve: Curve | None = None

    def at(self, clock_s: Floats) -> Floats:
        """Position at each clock time (n,), from the leg's start on."""
        if self.curve is None:
            return np.full_like(clock_s, self.start)
        return self.start + self.curve.travelled(clock_s - self.start_s)


_KEPT = 32
"""Legs of a path that are remembered."""


@dataclass(frozen=True)
class Path:
    """Where something was, is, and will be if nobody interferes. A value: safe to hand to other threads."""

    legs: tuple[Leg, ...]

    def then(self, leg: Leg) -> "Path":
        """Go on with another leg from its start; what was to come after that moment does not."""
        past = [earlier for earlier in self.legs if earlier.start_s < leg.start_s]
        return Path((*past[-_KEPT:], leg))

    def at(self, clock_s: Floats) -> Floats:
        """Position at each clock time (n,)."""
        starts = [leg.start_s for leg in self.legs]
        which = np.maximum(np.searchsorted(starts, clock_s, side="right") - 1, 0)
        position = np.zeros(len(clock_s))
        for index in np.unique(which):
            here = which == index
            position[here] = self.legs[int(index)].at(clock_s[here])
        return position

    def now(self, clock_s: float) -> float:
        """Position at one clock time."""
        return float(self.at(np.array([clock_s]))[0])

    def speed(self, clock_s: float) -> float:
        """Speed at one clock time, 0 where the leg is over."""
        leg = [leg for leg in self.legs if leg.start_s <= clock_s][-1]
        if leg.curve is None or clock_s - leg.start_s >= leg.curve.duration_s:
            return 0.0
        return leg.curve.speed(clock_s - leg.start_s)
