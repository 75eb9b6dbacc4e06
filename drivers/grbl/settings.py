"""What bench.toml can tell the driver."""

from typing import Literal

from pydantic import PositiveFloat

from drivers.polled_stage import PolledStageSettings


class GrblSettings(PolledStageSettings):
    """The ``[stage]`` table for ``driver = "grbl"``."""

    axis: Literal["X", "Y", "Z"] = "X"
    """Axis of the controller that the stage is plugged into."""

    travel_mm: tuple[float, float]
    """Lowest and highest position allowed, in machine coordinates: after homing they are often negative."""

    max_velocity_mm_s: PositiveFloat
    """Highest velocity allowed; not above ``$110`` of the controller."""

    max_acceleration_mm_s2: PositiveFloat
    """Highest acceleration allowed. A profile's acceleration is written to ``$120`` where another one stands there."""

    home_position_mm: float = 0.0
    """Position that the controller reports after homing: often the pull-off or the travel, with a minus."""

    home_timeout_s: PositiveFloat = 120.0
    """Longest time of homing, during which the controller is mute; it searches up to 1.5 times its longest travel."""

    unlock: bool = False
    """Release the alarm lock of the start (``$X``) when the stage is opened: for a stage without limit switches."""

    require_home: bool = False
    """Refuse moves until the stage has been homed in this run of the program."""

    boot_s: PositiveFloat = 3.0
    """Longest time that the controller may take to start: opening the port resets many boards."""

    poll_s: PositiveFloat = 0.002
    """Time between two looks at the port while an answer is awaited, in seconds."""

    @property
    def axis_index(self) -> int:
        """Index of the axis in positions and settings."""
        return "XYZ".index(self.axis)
