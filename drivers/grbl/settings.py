"""What bench.toml can tell the driver."""

from typing import Literal, Self

from pydantic import PositiveFloat, PositiveInt, model_validator

from drivers.grbl.codec import BAUD
from protocols import Frozen, StageLimits


class GrblSettings(Frozen):
    """The ``[stage]`` table for ``driver = "grbl"``."""

    port: str = ""
    """Serial port (``COM3``, ``/dev/ttyUSB0``) or pyserial URL. May be left out where bench.toml names a transport."""

    baud: PositiveInt = BAUD
    """Speed of the line: 115200 in GRBL 1.1 [V]."""

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

    reply_margin_s: PositiveFloat = 0.5
    """Time that the controller may think about an answer, beyond the time of the bytes on the line, in seconds."""

    poll_s: PositiveFloat = 0.002
    """Time between two looks at the port while an answer is awaited, in seconds."""

    @model_validator(mode="after")
    def _one_that_can_be(self) -> Self:
        low, high = self.travel_mm
        if not low < high:
            raise ValueError(f"travel_mm is [{low:g}, {high:g}]: the lowest position comes first")
        if not low <= self.home_position_mm <= high:
            raise ValueError(f"home_position_mm is {self.home_position_mm:g}, outside travel_mm [{low:g}, {high:g}]")
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
    def axis_index(self) -> int:
        """Index of the axis in positions and settings."""
        return "XYZ".index(self.axis)
