"""What bench.toml can tell the driver. What nobody can know from public sources has no default."""

from typing import Literal, Self

from pydantic import NonNegativeFloat, PositiveFloat, PositiveInt, model_validator

from drivers.polled_stage import SerialStageSettings
from drivers.zolix.scale import Scale


class Ka400zSettings(SerialStageSettings):
    """The ``[stage]`` table for ``driver = "ka400z"``."""

    dialect: Literal["auto", "mc600", "sc300"] = "auto"
    """Controller on the bench; ``auto`` asks it."""

    axis: Literal["X", "Y", "Z", "T"] = "X"
    """Axis of the controller that the stage is plugged into. An SC300 has no T."""

    lead_mm: PositiveFloat
    """Way of one turn of the screw. Unknown for the KA400Z; 4 and 5 are equally plausible: measure it."""

    microsteps: PositiveInt
    """Pulses a full step, as the switches inside the controller are set (an SC300 leaves the factory with 8)."""

    full_steps_per_rev: PositiveInt = 200
    """Full steps a turn of the motor. 200 (1.8 degrees) is inferred from other Zolix stages: check the motor's label."""

    max_velocity_mm_s: PositiveFloat
    """Highest velocity allowed. Unknown for the KA400Z; comparable stages run at 20 to 50 mm/s."""

    max_acceleration_mm_s2: PositiveFloat
    """Highest acceleration allowed. Unknown for the KA400Z."""

    home_velocity_mm_s: PositiveFloat
    """Velocity of homing. Unknown for the KA400Z."""

    initial_velocity_mm_s: NonNegativeFloat = 0.0
    """Start velocity of moves whose profile does not state one. Whether a controller takes 0 is not known."""

    home_position_mm: float = 0.0
    """Position that the controller reports after homing. It is not known: 0 is an assumption that the first homing tests."""

    home_timeout_s: PositiveFloat | None = None
    """Longest time of homing; None takes the whole travel at homing velocity plus 20 % plus one second."""

    require_home: bool = False
    """Refuse moves until the stage has been homed in this run of the program."""

    position_in_motion: Literal["auto", "ask", "predict"] = "auto"
    """Whether the controller is asked for its position while it moves. ``auto``: an MC600 is, an SC300 is not,
    and one that leaves the question without an answer is predicted from then on."""

    @model_validator(mode="after")
    def _one_that_can_be(self) -> Self:
        if self.dialect == "sc300" and self.axis == "T":
            raise ValueError("axis T: an SC300 has X, Y and Z only")
        if self.home_velocity_mm_s > self.max_velocity_mm_s:
            raise ValueError("home_velocity_mm_s is above max_velocity_mm_s")
        return self

    @property
    def scale(self) -> Scale:
        """Number of pulses that move the stage by one millimetre."""
        return Scale(pulses_per_mm=self.full_steps_per_rev * self.microsteps / self.lead_mm)
