"""The ``[stage.emulator]`` table of ``transport = "zaber-emulator"``. Marks as in the hardware sheet."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, model_validator

from protocols import Frozen
from sim_backends.bench.bounds import Factor, Index, LengthMm, Number, PlaceMm, Seconds


class LostReply(Frozen):
    """A reply that never arrives. The command is carried out."""

    kind: Literal["lost-reply"]
    """Tells this table from the others."""

    at: str = ""
    """Beginning of the command's words; empty: any."""

    nth: Number = 1
    """Number of the reply among those that the fault is for, from 1."""


class CorruptedByte(Frozen):
    """A reply with one wrong byte; its checksum, where there is one, no longer fits."""

    kind: Literal["corrupted-byte"]
    """Tells this table from the others."""

    at: str = ""
    """Beginning of the command's words; empty: any."""

    nth: Number = 1
    """Number of the reply among those that the fault is for, from 1."""

    byte: Index = 18
    """Index of the byte, from 0; beyond the end, the last but the line's end."""


class OldReply(Frozen):
    """The reply before comes again, with its old id, ahead of the true one."""

    kind: Literal["old-reply"]
    """Tells this table from the others."""

    nth: Number = 2
    """Number of the reply, from 1; the first has none before it."""


class Chatter(Frozen):
    """Alerts and infos come between each command and its reply."""

    kind: Literal["chatter"]
    """Tells this table from the others."""


class Rejected(Frozen):
    """A command is rejected, and not carried out."""

    kind: Literal["rejected"]
    """Tells this table from the others."""

    at: str
    """Beginning of the command's words."""

    word: str = "BADDATA"
    """Reason that it gives."""

    nth: Number = 1
    """Number of the command among those that the fault is for, from 1."""


class Mute(Frozen):
    """The controller says nothing any more, though it still obeys."""

    kind: Literal["mute"]
    """Tells this table from the others."""

    at: str = ""
    """Beginning of the command; empty: any."""

    nth: Number = 1
    """Which of them, from 1."""

    behind: bool = False
    """Whether that one is still carried out and answered."""


class Stall(Frozen):
    """Something blocks the carriage: the controller sees it, stops and raises FS."""

    kind: Literal["stall"]
    """Tells this table from the others."""

    nth: Number = 1
    """Number of the move, from 1."""

    after: Annotated[float, Field(ge=0, lt=1)] = 0.5
    """Part of the distance that is still covered."""


class PortVanishes(Frozen):
    """The port is gone, as when the USB adapter is pulled out."""

    kind: Literal["port-vanishes"]
    """Tells this table from the others."""

    at: str = ""
    """Beginning of the command; empty: any."""

    nth: Number = 1
    """Which of them, from 1."""

    behind: bool = False
    """Whether that one is still carried out and answered."""


ZaberFault: TypeAlias = Annotated[
    LostReply | CorruptedByte | OldReply | Chatter | Rejected | Mute | Stall | PortVanishes,
    Field(discriminator="kind"),
]
"""Something that goes wrong on this controller."""


class ZaberEmulatorSettings(Frozen):
    """One device with one axis that carries the object."""

    device: Annotated[int, Field(ge=1, le=99)] = 1
    """Its number in the chain."""

    baud: Number = 115_200
    """Speed of the line [V]."""

    turnaround_s: Seconds = 0.0005
    """Time from the end of a command to the start of its reply, in seconds [U]."""

    microsteps_per_mm: Annotated[float, Field(gt=0, le=1e7)] = 15_625.0
    """Microsteps of one millimetre: 64 nm each."""

    travel_mm: tuple[PlaceMm, PlaceMm] = (0.0, 400.0)
    """``limit.min`` and ``limit.max``, in millimetres from the home position."""

    start_mm: PlaceMm = 0.0
    """Position of the carriage when power comes. The controller calls it 0 until it is homed [U]."""

    referenced: bool = False
    """Whether the controller knows its position when power comes, as one with an absolute encoder does; else WR [V]."""

    max_velocity_mm_s: LengthMm = 100.0
    """Highest velocity that ``set maxspeed`` takes."""

    velocity_mm_s: LengthMm = 10.0
    """Velocity when power comes [U]."""

    acceleration_mm_s2: LengthMm = 100.0
    """Acceleration when power comes [U]."""

    speed_factor: Factor = 1.6384
    """``maxspeed`` for one microstep a second [R]."""

    acceleration_factor: Annotated[float, Field(gt=0, le=1e3)] = 1.6384e-4
    """``accel`` for one microstep a second squared [R]."""

    driver_enabled: bool = True
    """Whether the motor has current; otherwise FO, and moves are rejected."""

    parked: bool = False
    """Whether the axis is parked: moves are rejected."""

    checksums: Literal["as asked", "always", "never"] = "as asked"
    """When replies carry a checksum [I]."""

    faults: tuple[ZaberFault, ...] = ()
    """Faults, in any number."""

    @model_validator(mode="after")
    def _stands_inside(self) -> "ZaberEmulatorSettings":
        low, high = self.travel_mm
        if not low <= self.start_mm <= high or not low <= 0.0 <= high or low == high:
            raise ValueError("travel_mm must be a range that holds start_mm and the home position 0")
        return self
