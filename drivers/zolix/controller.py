"""A controller in millimetres: commands through the wire, readings checked against what is already known."""

from dataclasses import dataclass
from typing import Final

from drivers.zolix.events import Codec, Command, Position
from drivers.zolix.scale import Scale, Speeds
from drivers.zolix.wire import Wire
from protocols import MotionProfile, ProtocolViolation


@dataclass(frozen=True)
class Reading:
    """A position that the controller has told."""

    mm: float

    time_s: float
    """The middle between question and answer."""


class Controller:
    """One axis of a Zolix controller."""

    def __init__(self, wire: Wire, codec: Codec, scale: Scale) -> None:
        self.wire: Final = wire
        self.scale: Final = scale
        self._codec = codec
        self._sent: Speeds | None = None

    def set_up(self) -> None:
        """Set the unit."""
        for command in self._codec.set_up():
            self.wire.exchange(command)

    def same(self, one_mm: float, other_mm: float) -> bool:
        """Whether two positions are the same to within one and a half pulses."""
        return abs(one_mm - other_mm) <= self.scale.tolerance_mm

    def ask(self) -> Reading:
        """Ask once for the position."""
        reply = self.wire.exchange(self._codec.ask_position())
        assert isinstance(reply.event, Position)  # noqa: S101 (the exchange gives what its command awaits)
        return Reading(self.scale.mm(reply.event.pulses), reply.time_s)

    def ask_within(self, low_mm: float, high_mm: float) -> Reading:
        """Ask for a position that should lie between two others; one that does not must be told twice to be believed.

        The line has no checksum: a lost digit makes another number.

        Raises:
            ProtocolViolation: two answers that neither fit what is known nor each other.
        """
        slack_mm = self.scale.tolerance_mm
        first = self.ask()
        if low_mm - slack_mm <= first.mm <= high_mm + slack_mm:
            return first
        second = self.ask()
        if low_mm - slack_mm <= second.mm <= high_mm + slack_mm or self.same(first.mm, second.mm):
            return second
        raise ProtocolViolation(
            device=self.wire.device,
            saw=f"positions {first.mm:g} mm and {second.mm:g} mm, one after the other",
            expected=f"a position from {low_mm:g} to {high_mm:g} mm, or the same one twice",
            remedy="check the cable for disturbance, and stop the stage if it moves by itself",
        )

    def set_speeds(self, speeds: Speeds) -> None:
        """Send what has changed since the last move, so that the start velocity is never above the velocity."""
        sent, self._sent = self._sent, None
        velocity = self._codec.set_velocity(speeds.velocity)
        initial = self._codec.set_initial_velocity(speeds.initial)
        commands: list[Command] = []
        if sent is None or sent.acceleration != speeds.acceleration:
            commands.append(self._codec.set_acceleration(speeds.acceleration))
        pair: list[Command] = []
        if sent is None or sent.initial != speeds.initial:
            pair.append(initial)
        if sent is None or sent.velocity != speeds.velocity:
            pair.append(velocity)
        if sent is not None and speeds.initial >= sent.velocity:
            pair.reverse()
        for command in (*commands, *pair):
            self.wire.exchange(command)
        self._sent = speeds

    def begin_move(self, standing_at_mm: float, target_mm: float, *, relative: bool, stops: int) -> float:
        """Start a move, unless a stop came after ``stops``; give the time of its start."""
        here, there = self.scale.pulses(standing_at_mm), self.scale.pulses(target_mm)
        command = self._codec.move_by(there - here) if relative else self._codec.move_to(there, here)
        return self.wire.begin(command, unless_stopped_since=stops)

    def begin_home(self, profile: MotionProfile, *, stops: int) -> float:
        """Start homing, unless a stop came after ``stops``; give the time of its start."""
        self.set_speeds(self.scale.speeds(profile))
        if command := self._codec.set_home_velocity(self.scale.pulses(profile.velocity_mm_s)):
            self.wire.exchange(command)
        return self.wire.begin(self._codec.home(), unless_stopped_since=stops)
