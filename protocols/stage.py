"""Linear stages: one axis, millimetres, no hidden limits."""

import math
from typing import Protocol, Self, runtime_checkable

from pydantic import NonNegativeFloat, PositiveFloat

from protocols.errors import MotionTooFast, TravelExceeded
from protocols.values import DeviceIdentity, Frozen

_GENTLE_MM_S = 10.0
_GENTLE_MM_S2 = 50.0


class StageLimits(Frozen):
    """Limits of a stage, and the checks of a move against them.

    A target or a speed outside is an error before a byte is sent, never clipped.
    """

    travel_mm: tuple[float, float]
    """Lowest and highest position, in millimetres."""

    max_velocity_mm_s: PositiveFloat
    """Highest velocity, in mm/s."""

    max_acceleration_mm_s2: PositiveFloat
    """Highest acceleration, in mm/s^2."""

    @property
    def gentle_profile(self) -> "MotionProfile":
        """How a stage is moved where nobody has said how: 10 mm/s and 50 mm/s^2, or what it can do."""
        return MotionProfile(
            velocity_mm_s=min(_GENTLE_MM_S, self.max_velocity_mm_s),
            acceleration_mm_s2=min(_GENTLE_MM_S2, self.max_acceleration_mm_s2),
        )

    def check_target(self, target_mm: float, device: str) -> None:
        """Refuse a target outside the travel, or one that is no number; ``device`` is the name that the error carries.

        Raises:
            TravelExceeded: names the target and both ends of the travel.
        """
        low_mm, high_mm = self.travel_mm
        if not low_mm <= target_mm <= high_mm:  # so that NaN is refused too
            raise TravelExceeded(device, target_mm, self.travel_mm)

    def check_profile(self, profile: "MotionProfile", device: str) -> None:
        """Refuse a profile that is faster or steeper than the stage may move, or that starts above its own velocity.

        Raises:
            MotionTooFast: names what was asked and the most that is allowed.
        """
        for what, asked, highest, unit in (
            ("velocity", profile.velocity_mm_s, self.max_velocity_mm_s, "mm/s"),
            ("acceleration", profile.acceleration_mm_s2, self.max_acceleration_mm_s2, "mm/s^2"),
            ("initial velocity", profile.initial_velocity_mm_s, profile.velocity_mm_s, "mm/s"),
        ):
            if not asked <= highest:
                raise MotionTooFast(device, what, asked, highest, unit)


class MotionProfile(Frozen):
    """A trapezoid in velocity: ramp, cruise, equal ramp down (a triangle where the distance is too short to cruise)."""

    velocity_mm_s: PositiveFloat
    """Velocity between the ramps, in mm/s."""

    acceleration_mm_s2: PositiveFloat
    """Acceleration of the first ramp and deceleration of the last, in mm/s^2."""

    initial_velocity_mm_s: NonNegativeFloat = 0.0
    """Velocity that a stepper starts and ends with, without a ramp, in mm/s."""

    @property
    def ramp_time_s(self) -> float:
        """Time from the start to cruise velocity, in seconds."""
        return max(0.0, self.velocity_mm_s - self.initial_velocity_mm_s) / self.acceleration_mm_s2

    @property
    def ramp_mm(self) -> float:
        """Length of one ramp in millimetres, (v^2 - v0^2) / 2a."""
        rise = self.velocity_mm_s**2 - self.initial_velocity_mm_s**2
        return max(0.0, rise) / (2 * self.acceleration_mm_s2)

    def duration_s(self, distance_mm: float) -> float:
        """Give the time in seconds of a whole move over ``distance_mm`` (its sign does not matter)."""
        distance, v0 = abs(distance_mm), self.initial_velocity_mm_s
        if distance >= 2 * self.ramp_mm:
            return 2 * self.ramp_time_s + (distance - 2 * self.ramp_mm) / self.velocity_mm_s
        return 2 * (self._peak_mm_s(distance) - v0) / self.acceleration_mm_s2

    def travelled_mm(self, distance_mm: float, elapsed_s: float) -> float:
        """Give the signed distance in millimetres covered ``elapsed_s`` after the start of a move over ``distance_mm``."""
        sign = -1.0 if distance_mm < 0 else 1.0
        distance, total = abs(distance_mm), self.duration_s(distance_mm)
        t = min(max(elapsed_s, 0.0), total)
        a, v0 = self.acceleration_mm_s2, self.initial_velocity_mm_s
        peak = self.velocity_mm_s if distance >= 2 * self.ramp_mm else self._peak_mm_s(distance)
        ramp_s = max(0.0, peak - v0) / a
        if t <= ramp_s:
            covered = v0 * t + a * t * t / 2
        elif t < total - ramp_s:
            covered = v0 * ramp_s + a * ramp_s**2 / 2 + peak * (t - ramp_s)
        else:
            rest = total - t
            covered = distance - (v0 * rest + a * rest * rest / 2)
        return sign * covered

    def _peak_mm_s(self, distance: float) -> float:
        peak = math.sqrt(self.acceleration_mm_s2 * distance + self.initial_velocity_mm_s**2)
        return min(max(peak, self.initial_velocity_mm_s), self.velocity_mm_s)


class StagePosition(Frozen):
    """Position of a stage, and how it is known."""

    time_s: float
    """Moment on the bench's clock, in seconds: the middle between question and answer, or the moment of the prediction."""

    commanded_mm: float
    """Target of the motion now under way, or of the last one, in millimetres."""

    reported_mm: float
    """Position of the stage in millimetres: the controller's own answer, or a prediction from the profile."""

    predicted: bool = False
    """True where the controller is mute during motion, so that ``reported_mm`` comes from the profile."""


@runtime_checkable
class Motion(Protocol):
    """One motion under way. Many threads may hold it."""

    @property
    def target_mm(self) -> float:
        """Position at which the motion is to end, in millimetres."""
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
            DeviceTimeout: the stage still moves; names the distance covered.
            DeviceError: the motion ended elsewhere (a stop, a limit switch, a lost step).
        """
        ...

    def stop(self) -> None:
        """Stop this motion; nothing happens where it is over."""
        ...


@runtime_checkable
class LinearStage(Protocol):
    """Moves one axis. Positive is the direction in which ``position`` grows.

    ``stop`` never waits behind a move or a reader, may come from any thread, and may come twice. A move while another is
    under way is refused. As a context manager it is open from construction on; leaving it stops the stage.
    """

    @property
    def identity(self) -> DeviceIdentity:
        """Identity of the stage and of its controller."""
        ...

    @property
    def limits(self) -> StageLimits:
        """Travel, highest velocity and highest acceleration."""
        ...

    @property
    def homed(self) -> bool:
        """Whether ``position`` is known to be true to the stage's own origin."""
        ...

    @property
    def stands_by_s(self) -> float:
        """Moment on the bench's clock, in seconds, by which every motion that was started is over, even if no stop is obeyed.

        It follows from what was commanded (start, distance and profile; for homing the longest search) and asks the controller
        nothing, so that it is known where the controller is mute too. Before the first motion it is in the past.
        """
        ...

    def check(self, target_mm: float, profile: MotionProfile) -> None:
        """Raise what ``move_to`` would raise for this target and profile, and move nothing.

        ``StageLimits.check_target`` and ``check_profile`` are what every stage asks; a driver may refuse more.
        """
        ...

    def position(self) -> StagePosition:
        """Tell where the stage is now, during a motion too."""
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
        """Start to look for the origin and return at once. No stage homes by itself."""
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
