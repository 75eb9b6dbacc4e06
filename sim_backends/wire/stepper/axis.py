"""One motor axis: the controller's pulse counter, and where the carriage really is."""

from typing import Literal, TypeAlias

from sim_backends.wire.stepper.motion import Braking, Curve, Cut, Leg, Path, Rates, Slack, Trapezoid, cut_at

Direction: TypeAlias = Literal["direct", "negative", "positive"]
"""How homing finds the origin: straight, or from a limit switch."""


class Axis:
    """Counter and carriage in pulses on one clock.

    The carriage's zero is the home position. The counter starts at 0 wherever the carriage stands when power comes.
    """

    def __init__(self, *, low: int, high: int, start: int, backlash: int = 0, limit_sticks: bool = False) -> None:
        """Power up.

        Args:
            low: lower limit switch.
            high: upper limit switch.
            start: where the carriage stands.
            backlash: play of the nut on the screw. At first it is taken up for motion upwards.
            limit_sticks: a limit switch that was once reached never lets go.
        """
        self._low, self._high = low, high
        self._limit_sticks = limit_sticks
        self._backlash = backlash
        # Play ahead of an upward motion, and the counter value at which it was so large.
        self._play_up, self._play_since = 0.0, 0.0
        self.counter = Path((Leg(0.0, 0.0),))
        self.carriage = Path((Leg(0.0, float(start)),))
        self.end_s = 0.0
        self.target = 0
        self.homed = False
        self._homing = False
        self.motion = 0
        """Number of the present or last motion: tells a completion that was overtaken by a stop."""

    def moving(self, now_s: float) -> bool:
        """Whether a motion is under way."""
        return now_s < self.end_s

    def reported(self, now_s: float) -> int:
        """What the counter says."""
        return round(self.counter.now(now_s))

    def blocked(self, now_s: float, distance: int) -> bool:
        """Whether a limit switch forbids this direction."""
        at = self.carriage.now(now_s)
        low, high = at <= self._low, at >= self._high
        if self._limit_sticks and (low or high):
            return True
        return (low and distance < 0) or (high and distance > 0)

    def _play(self, now_s: float, *, up: bool) -> float:
        """Distance that the screw turns before the carriage follows upwards or downwards."""
        turned = self.counter.now(now_s) - self._play_since
        play_up = min(max(self._play_up - turned, 0.0), float(self._backlash))
        return play_up if up else self._backlash - play_up

    def move(self, now_s: float, distance: int, rates: Rates, stall_at: float | None = None) -> None:
        """Start a motion over ``distance`` pulses. A limit switch in between ends it abruptly.

        Args:
            now_s: clock time of the start.
            distance: signed.
            rates: speeds and acceleration.
            stall_at: part of the distance after which the motor loses its steps; the counter does not know.
        """
        self.target = self.reported(now_s) + distance
        screw = Trapezoid(distance, rates)
        nut = Slack(screw, self._play(now_s, up=distance > 0))
        room = self._room(now_s, up=distance > 0)
        if stall_at is not None and stall_at * abs(distance) < room:
            self._go(now_s, screw, cut_at(nut, max(0.0, stall_at * abs(distance) - nut.play)))
            return
        stopped = cut_at(nut, room)
        self._go(now_s, Cut(screw, stopped.duration_s), stopped)

    def _room(self, now_s: float, *, up: bool) -> float:
        """Distance to the limit switch."""
        at = self.carriage.now(now_s)
        return self._high - at if up else at - self._low

    def _go(self, now_s: float, told: Curve, true: Curve) -> None:
        self.motion += 1
        self._homing = False
        self._play_up, self._play_since = self._play(now_s, up=True), self.counter.now(now_s)
        self.end_s = now_s + told.duration_s
        self.counter = self._follow(self.counter, now_s, told)
        self.carriage = self._follow(self.carriage, now_s, true)

    def _follow(self, path: Path, now_s: float, curve: Curve) -> Path:
        """Add a motion that ends on a whole pulse."""
        moved = path.then(Leg(now_s, path.now(now_s), curve))
        return moved.then(Leg(self.end_s, float(round(moved.now(self.end_s)))))

    def stand(self, now_s: float) -> None:
        """A motion of no length: over as soon as it has begun."""
        self.motion += 1
        self.end_s, self.target = now_s, self.reported(now_s)

    def stop(self, now_s: float, rates: Rates, *, decelerate: bool) -> None:
        """End the present motion, with a ramp or abruptly."""
        if not self.moving(now_s):
            return
        self.homed = self.homed and not self._homing
        speed = self.counter.speed(now_s)
        told: Curve = Braking(speed, rates)
        if not decelerate:
            told = Cut(told, 0.0)
        nut = Slack(told, self._play(now_s, up=speed > 0))
        if self.carriage.speed(now_s) == 0 and nut.play == 0:
            self._go(now_s, told, Cut(told, 0.0))  # stalled
        else:
            stopped = cut_at(nut, self._room(now_s, up=speed > 0))
            self._go(now_s, Cut(told, stopped.duration_s), stopped)
        self.target = self.reported(self.end_s)

    def home(self, now_s: float, rates: Rates, direction: Direction, duration_s: float | None) -> None:
        """Look for the origin; at the end carriage and counter are at 0.

        Args:
            now_s: clock time of the start.
            rates: with the homing speed.
            direction: straight to the origin, or over the limit switch on that side.
            duration_s: how long it takes; None: by the homing speed.
        """
        self.motion += 1
        switch = {"direct": 0, "negative": self._low, "positive": self._high}[direction]
        at, leg_s = self.carriage.now(now_s), now_s
        for goal in (switch, 0):
            if goal == at:
                continue
            leg_rates = rates
            if duration_s is not None:
                speed = (abs(switch - self.carriage.now(now_s)) + abs(switch)) / duration_s
                leg_rates = Rates(speed, speed, rates.acceleration)
            curve = Trapezoid(goal - at, leg_rates)
            self.counter = self.counter.then(Leg(leg_s, self.counter.now(leg_s), curve))
            self.carriage = self.carriage.then(Leg(leg_s, at, curve))
            at, leg_s = float(goal), leg_s + curve.duration_s
        self.end_s = leg_s
        self.counter = self.counter.then(Leg(leg_s, 0.0))
        self.carriage = self.carriage.then(Leg(leg_s, 0.0))
        self.target, self.homed, self._homing = 0, True, True
        # The last leg of homing took the play up in its own direction.
        came_down = (switch or self.carriage.now(now_s)) > 0
        self._play_up, self._play_since = (float(self._backlash) if came_down else 0.0), 0.0
