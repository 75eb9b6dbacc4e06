"""What bench.toml can tell of any stage on a serial line."""

from typing import Self

from pydantic import PositiveFloat, PositiveInt, model_validator

from drivers.serial_line import LineWire, open_port
from protocols import BenchContext, Frozen, StageLimits


class SerialStageSettings(Frozen):
    """The keys of ``[stage]`` that all drivers of stages on a serial line have in common."""

    port: str = ""
    """Serial port (``COM3``, ``/dev/ttyUSB0``) or pyserial URL. May be left out where bench.toml names a transport."""

    travel_mm: tuple[float, float]
    """Lowest and highest position allowed, in the controller's own coordinate."""

    max_velocity_mm_s: PositiveFloat
    """Highest velocity allowed."""

    max_acceleration_mm_s2: PositiveFloat
    """Highest acceleration allowed."""

    home_position_mm: float = 0.0
    """Position that the controller reports after homing."""

    require_home: bool = False
    """Refuse moves while the controller does not know its origin."""

    reply_margin_s: PositiveFloat = 0.5
    """Time that the controller may think about an answer, beyond the time of the bytes on the line, in seconds."""

    poll_s: PositiveFloat = 0.001
    """Time between two looks at the port while an answer is awaited, in seconds."""

    @model_validator(mode="after")
    def _travel_that_can_be(self) -> Self:
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


class PolledStageSettings(SerialStageSettings):
    """Those of a stage that tells at any time where it is."""

    baud: PositiveInt = 115_200
    """Speed of the line: 115200 from the factory [V]."""

    def open_wire(self, context: BenchContext, *, device: str, longest: int) -> LineWire:
        """Open the port, or take ``context.transport``, and give the lines on it; ``longest`` is the longest in bytes.

        Raises:
            InputError: neither port nor transport.
            DriverUnavailable: the port cannot be opened.
        """
        port = open_port(self.port, context.transport, device=device, table="stage", baud=self.baud)
        return LineWire(
            port,
            context.clock,
            device=device,
            baud=self.baud,
            longest=longest,
            margin_s=self.reply_margin_s,
            poll_s=self.poll_s,
        )
