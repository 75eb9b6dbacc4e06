"""What bench.toml can tell the driver."""

from typing import Annotated, Self

from pydantic import Field, PositiveFloat, model_validator

from drivers.polled_stage import PolledStageSettings
from protocols import MotionProfile


class ZaberSettings(PolledStageSettings):
    """The ``[stage]`` table for ``driver = "zaber"``."""

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

    home_velocity_mm_s: PositiveFloat = 5.0
    """Velocity of homing. That ``maxspeed`` rules it is not known [U]."""

    home_timeout_s: PositiveFloat | None = None
    """Longest time of homing; None takes the whole travel at homing velocity plus 20 % plus one second."""

    require_home: bool = False
    """Refuse moves while the controller says that it does not know its origin (WR, WH)."""

    @model_validator(mode="after")
    def _homing_that_can_be(self) -> Self:
        if self.home_velocity_mm_s > self.max_velocity_mm_s:
            raise ValueError("home_velocity_mm_s is above max_velocity_mm_s")
        return self

    @property
    def home_profile(self) -> MotionProfile:
        """Profile of homing."""
        return MotionProfile(velocity_mm_s=self.home_velocity_mm_s, acceleration_mm_s2=self.max_acceleration_mm_s2)
