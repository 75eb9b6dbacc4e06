"""Linear stages: one axis, millimetres, no hidden limits."""

import math
from typing import Protocol, Self, runtime_checkable

from pydantic import NonNegativeFloat, PositiveFloat

from protocols.values import DeviceIdentity, Frozen


class StageLimits(Frozen):
    """What a stage may do. A target or a speed outside is an error before a byte is sent, never clipped."""

    travel_mm: tuple[float, float]
    """Lowest and highest position."""

    max_velocity_mm_s: PositiveFloat
    """Highest velocity."""

    max_acceleration_mm_s2: PositiveFloat
    """Highest acceleration."""


class MotionProfile(Frozen):
    """A trapezoid in velocity: ramp, cruise, equal ramp down (a triangle where the way is too short to cruise)."""

    velocity_mm_s: PositiveFloat
    """Cruise velocity."""

    acceleration_mm_s2: PositiveFloat
    """Of both ramps."""

    initial_velocity_mm_s: NonNegativeFloat = 0.0
    """Velocity that a stepper starts and ends with, without a ramp."""

    @property
    def ramp_time_s(self) -> float:
        """From the start to cruise velocity."""
        return max(0.0, self.velocity_mm_s - self.initial_velocity_mm_s) / self.acceleration_mm_s2

    @property
    def ramp_mm(self) -> float:
        """Way of one ramp, (v^2 - v0^2) / 2a."""
        rise = self.velocity_mm_s**2 - self.initial_velocity_mm_s**2
        return max(0.0, rise) / (2 * self.acceleration_mm_s2)

    def duration_s(self, distance_mm: float) -> float:
        """Time of a whole move over ``distance_mm`` (its sign does not matter)."""
        distance, v0 = abs(distance_mm), self.initial_velocity_mm_s
        if distance >= 2 * self.ramp_mm:
            return 2 * self.ramp_time_s + (distance - 2 * self.ramp_mm) / self.velocity_mm_s
        return 2 * (self._peak_mm_s(distance) - v0) / self.acceleration_mm_s2

    def travelled_mm(self, distance_mm: float, elapsed_s: float) -> float:
        """Signed way done ``elapsed_s`` after the start of a move over ``distance_mm``."""
        sign = -1.0 if distance_mm < 0 else 1.0
        distance, total = abs(distance_mm), self.duration_s(distance_mm)
        t = min(max(elapsed_s, 0.0), total)
        a, v0 = self.acceleration_mm_s2, self.initial_velocity_mm_s
        peak = self.velocity_mm_s if distance >= 2 * self.ramp_mm else self._peak_mm_s(distance)
        ramp_s = max(0.0, peak - v0) / a
        if t <= ramp_s:
            way = v0 * t + a * t * t / 2
        elif t < total - ramp_s:
            way = v0 * ramp_s + a * ramp_s**2 / 2 + peak * (t - ramp_s)
        else:
            rest = total - t
            way = distance - (v0 * rest + a * rest * rest / 2)
        return sign * way

    def _peak_mm_s(self, distance: float) -> float:
        peak = math.sqrt(self.acceleration_mm_s2 * distance + self.initial_velocity_mm_s**2)
        return min(max(peak, self.initial_velocity_mm_s), self.velocity_mm_s)


class StagePosition(Frozen):
    """Where a stage is, and how that is known."""

    time_s: float
    """On the bench's clock: the middle between question and answer, or the moment of the prediction."""

    commanded_mm: float
    """Where the motion now under way, or the last one, was told to go."""

    reported_mm: float
    """Where the stage is: the controller's own answer, or a prediction from the profile."""

    predicted: bool = False
    """True where the controller is mute during motion, so that ``reported_mm`` comes from the profile."""


@runtime_checkable
class Motion(Protocol):
    """One motion under way. Many threads may hold it."""

    @property
    def target_mm(self) -> float:
        """Where it goes."""
        ...

    @property
    def done(self) -> bool:
        """Whether the controller has said that the stage stands."""
        ...

    def wait(self, timeout_s: float | None = None) -> StagePosition:
        """Return the position, read back, when the stage stands.

        Args:
            timeout_s: None takes the profile's duration plus 20 % plus one second.

        Raises:
            DeviceTimeout: still under way; names the way done.
            DeviceError: the motion ended elsewhere (a stop, a limit switch, a lost step).
        """
        ...

    def stop(self) -> None:
        """Stop this motion; nothing happens where it is over."""
        ...


@runtime_checkable
class LinearStage(Protocol):
    """Moves one axis. Positive is the direction in which ``position`` grows.

    ``stop`` has a road of its own: it never waits behind a move, may come from any thread, and twice. A move while another
    is under way is refused. As a context manager it is open from construction on; leaving it stops the stage.
    """

    @property
    def identity(self) -> DeviceIdentity:
        """Who the device is."""
        ...

    @property
    def limits(self) -> StageLimits:
        """Travel, velocity, acceleration."""
        ...

    @property
    def homed(self) -> bool:
        """Whether ``position`` is known to be true to the stage's own origin."""
        ...

    def check(self, target_mm: float, profile: MotionProfile) -> None:
        """Raise what ``move_to`` would raise for this target and profile, and move nothing."""
        ...

    def position(self) -> StagePosition:
        """Where the stage is now, during a motion too."""
        ...

    def move_to(self, target_mm: float, profile: MotionProfile) -> Motion:
        """Start a move to an absolute position and return at once.

        Raises:
            TravelExceeded: the target is outside the travel; nothing was sent.
            MotionTooFast: the profile is outside the limits; nothing was sent.
            DeviceBusy: another motion is under way.
        """
        ...

    def move_by(self, distance_mm: float, profile: MotionProfile) -> Motion:
        """Start a move relative to where the stage stands; as ``move_to`` otherwise."""
        ...

    def home(self) -> Motion:
        """Look for the origin, only ever on request."""
        ...

    def stop(self) -> None:
        """Stop at once. Never raises for a stage that stands."""
        ...

    def __enter__(self) -> Self:
        """Give the open device."""
        ...

    def __exit__(self, *exc: object) -> None:
        """Stop, and let go of the device, even if stopping fails."""
        ...
