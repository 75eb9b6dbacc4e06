"""The ``[stage.emulator]`` table of ``transport = "grbl-emulator"``. Marks as in the hardware sheet."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, model_validator

from protocols import Frozen
from sim_backends.bench.bounds import Index, LengthMm, Level, Number, PlaceMm, Seconds, SomeSeconds


class LostReply(Frozen):
    """A line that never arrives. What it answers is carried out."""

    kind: Literal["lost-reply"]
    """Tells this table from the others."""

    at: str = ""
    """Beginning of the line, or the real-time byte, that it answers; empty: any."""

    nth: Number = 1
    """Number of the line among those that the fault is for, from 1."""


class LateReply(Frozen):
    """A line that comes late: perhaps after the next question."""

    kind: Literal["late-reply"]
    """Tells this table from the others."""

    at: str = ""
    """Beginning of the line that it answers; empty: any."""

    nth: Number = 1
    """Number of the line, from 1."""

    delay_s: SomeSeconds = 1.0
    """Time by which it is late, in seconds."""


class CorruptedByte(Frozen):
    """A line with one wrong byte. There is no checksum."""

    kind: Literal["corrupted-byte"]
    """Tells this table from the others."""

    at: str = ""
    """Beginning of the line that it answers; empty: any."""

    nth: Number = 1
    """Number of the line, from 1."""

    byte: Index = 3
    """Index of the byte, from 0; beyond the end, the last but the line's end."""


class Error(Frozen):
    """A line is answered by an error, and not carried out."""

    kind: Literal["error"]
    """Tells this table from the others."""

    at: str
    """Beginning of the line."""

    code: Annotated[int, Field(ge=1, le=38)] = 15
    """The error's number."""

    nth: Number = 1
    """Number of the line among those that the fault is for, from 1."""


class Mute(Frozen):
    """The controller says nothing any more, though it still obeys."""

    kind: Literal["mute"]
    """Tells this table from the others."""

    at: str = ""
    """Beginning of the line or real-time byte; empty: any."""

    nth: Number = 1
    """Which of them, from 1."""

    behind: bool = False
    """Whether that one is still carried out and answered."""


class Stall(Frozen):
    """The motor loses its steps and stands, while the controller goes on counting: GRBL is blind."""

    kind: Literal["stall"]
    """Tells this table from the others."""

    nth: Number = 1
    """Number of the jog, from 1."""

    after: Annotated[float, Field(ge=0, lt=1)] = 0.5
    """Part of the distance that is still covered."""


class NoSwitch(Frozen):
    """Homing finds no switch: ALARM:9 after its time."""

    kind: Literal["no-switch"]
    """Tells this table from the others."""


class Reset(Frozen):
    """The board starts anew by itself, as one that shares its supply with the motor may."""

    kind: Literal["reset"]
    """Tells this table from the others."""

    at: str = ""
    """Beginning of the line or real-time byte; empty: any."""

    nth: Number = 1
    """Which of them, from 1. It happens once."""

    behind: bool = False
    """Whether that one is still carried out and answered, and the next one is not."""


class PortVanishes(Frozen):
    """The port is gone, as when the USB cable is pulled out."""

    kind: Literal["port-vanishes"]
    """Tells this table from the others."""

    at: str = ""
    """Beginning of the line or real-time byte; empty: any."""

    nth: Number = 1
    """Which of them, from 1."""

    behind: bool = False
    """Whether that one is still carried out and answered."""


GrblFault: TypeAlias = Annotated[
    LostReply | LateReply | CorruptedByte | Error | Mute | Stall | NoSwitch | Reset | PortVanishes,
    Field(discriminator="kind"),
]
"""Something that goes wrong on this controller."""


class GrblEmulatorSettings(Frozen):
    """One board, one axis of which carries the object."""

    axis: Literal["X", "Y", "Z"] = "X"
    """The axis that carries the object."""

    baud: Number = 115_200
    """Speed of the line [V]."""

    turnaround_s: Seconds = 0.001
    """Time from the end of a line to its answer, in seconds [U]."""

    status_s: Seconds = 0.005
    """Time from ``?`` to the status line, in seconds: 5 to 20 ms [V]."""

    boot_s: Seconds = 0.5
    """Time from power, or a reset by the port, to the welcome, in seconds [R]: nothing before it is heard."""

    steps_per_mm: Annotated[float, Field(gt=0, le=1e6)] = 400.0
    """``$100``: steps a millimetre."""

    max_rate_mm_s: LengthMm = 50.0
    """``$110`` over 60: highest velocity; faster jogs are clipped to it."""

    acceleration_mm_s2: LengthMm = 100.0
    """``$120``: acceleration."""

    travel_mm: tuple[PlaceMm, PlaceMm] = (0.0, 400.0)
    """Positions of the switches, or of the ends, from the home position."""

    start_mm: PlaceMm = 0.0
    """Position of the carriage when power comes. The controller calls it 0."""

    home_position_mm: PlaceMm = 0.0
    """What the controller calls the home position."""

    soft_limits: bool = False
    """``$20``: whether a jog beyond the travel is refused (error 15)."""

    hard_limits: bool = True
    """``$21``: whether a switch that is reached raises ALARM:1 and loses the position."""

    homing: bool = True
    """``$22``: whether it can home, and is locked until it has."""

    home_rate_mm_s: LengthMm = 10.0
    """``$25`` over 60: velocity of the search."""

    report: Literal["MPos", "WPos"] = "MPos"
    """``$10``: which position status lines show."""

    work_offset_mm: PlaceMm = 0.0
    """Machine minus work coordinates."""

    inches: Level = 0.0
    """``$13``: 1 reports in inches."""

    faults: tuple[GrblFault, ...] = ()
    """Faults, in any number."""

    @model_validator(mode="after")
    def _stands_inside(self) -> "GrblEmulatorSettings":
        low, high = self.travel_mm
        if not low <= self.start_mm <= high or not low <= 0.0 <= high or low == high:
            raise ValueError("travel_mm must be a range that holds start_mm and the home position 0")
        return self
