"""What bench.toml can tell the driver."""

from typing import Annotated, Self

from pydantic import Field, PositiveFloat, PositiveInt, model_validator

from protocols import Frozen, MotionProfile, StageLimits


class ZaberSettings(Frozen):
    """The ``[stage]`` table for ``driver = "zaber"``."""

    port: str = ""
    """Serial port (``COM3``, ``/dev/ttyUSB0``) or pyserial URL. May be left out where bench.toml names a transport."""

    baud: PositiveInt = 115_200
    """Speed of the line: 115200 from the factory [V]."""

    device: Annotated[int, Field(ge=1, le=99)] = 1
    """Number of the device in its chain."""

    axis: Annotated[int, Field(ge=1, le=9)] = 1
    """Axis of that device."""

    microsteps_per_mm: PositiveFloat
    """Microsteps of one millimetre: resolution over the lead's way. It follows from the model; read it off its data sheet."""

    speed_factor: PositiveFloat = 1.6384
    """``maxspeed`` for one microstep a second. Recalled [R], in no source that was read: check it against the manual."""

    acceleration_factor: PositiveFloat = 1.6384e-4
    """``accel`` for one microstep a second squared. Recalled [R], as ``speed_factor``."""

    travel_mm: tuple[float, float]
    """Lowest and highest position allowed, in the controller's own coordinate."""

    max_velocity_mm_s: PositiveFloat
    """Highest velocity allowed."""

    max_acceleration_mm_s2: PositiveFloat
    """Highest acceleration allowed."""

    home_velocity_mm_s: PositiveFloat = 5.0
    """Velocity of homing. That ``maxspeed`` rules it is not known [U]."""

    home_position_mm: float = 0.0
    """Position that the controller reports after homing."""

    home_timeout_s: PositiveFloat | None = None
    """Longest time of homing; None takes the whole travel at homing velocity plus 20 % plus one second."""

    require_home: bool = False
    """Refuse moves while the controller says that it does not know its origin (WR, WH)."""

    reply_margin_s: PositiveFloat = 0.5
    """Time that the controller may think about an answer, beyond the time of the bytes on the line, in seconds."""

    poll_s: PositiveFloat = 0.001
    """Time between two looks at the port while an answer is awaited, in seconds."""

    @model_validator(mode="after")
    def _one_that_can_be(self) -> Self:
        low, high = self.travel_mm
        if not low < high:
            raise ValueError(f"travel_mm is [{low:g}, {high:g}]: the lowest position comes first")
        if not low <= self.home_position_mm <= high:
            raise ValueError(f"home_position_mm is {self.home_position_mm:g}, outside travel_mm [{low:g}, {high:g}]")
        if self.home_velocity_mm_s > self.max_velocity_mm_s:
            raise ValueError("home_velocity_mm_s is above max_velocity_mm_s")
        return self

    @property
    def limits(self) -> StageLimits:
        """Limits of the stage."""
        return StageLimits(
            travel_mm=self.travel_mm,
            max_velocity_mm_s=self.max_velocity_mm_s,
            max_acceleration_mm_s2=self.max_acceleration_mm_s2,
        )

    @property
    def home_profile(self) -> MotionProfile:
        """Profile of homing."""
        return MotionProfile(velocity_mm_s=self.home_velocity_mm_s, acceleration_mm_s2=self.max_acceleration_mm_s2)
