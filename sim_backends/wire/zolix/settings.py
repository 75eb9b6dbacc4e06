"""The ``[stage.emulator]`` tables: what the sheet leaves open about the controllers, and what shall go wrong.

Marks as in the hardware sheet: [V] verified, [S] second-hand, [I] inferred, [U] unknown.
"""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, model_validator

from protocols import Frozen
from sim_backends.bench.bounds import Index, LengthMm, Level, Number, PlaceMm, Seconds, SomeSeconds


class LostReply(Frozen):
    """A reply line that never arrives."""

    kind: Literal["lost-reply"]
    """Tells this table from the others."""

    at: str = ""
    """Beginning of the command it answers, or ``completion``; empty: any."""

    nth: Number = 1
    """Number of the line among those that the fault is for, from 1."""


class CorruptedByte(Frozen):
    """A reply line with one wrong byte."""

    kind: Literal["corrupted-byte"]
    """Tells this table from the others."""

    at: str = ""
    """Beginning of the command it answers, or ``completion``; empty: any."""

    nth: Number = 1
    """Number of the line among those that the fault is for, from 1."""

    byte: Index = 0
    """Index of the byte in the line, from 0; beyond its end, the last but the CR."""


class LateCompletion(Frozen):
    """The line that tells the end of a motion comes late: perhaps after the next query."""

    kind: Literal["late-completion"]
    """Tells this table from the others."""

    nth: Number = 1
    """Number of the completion, from 1."""

    delay_s: SomeSeconds = 0.5
    """Time by which the line is late, in seconds."""


class DuplicatedCompletion(Frozen):
    """The line that tells the end of a motion comes twice."""

    kind: Literal["duplicated-completion"]
    """Tells this table from the others."""

    nth: Number = 1
    """Number of the completion, from 1."""


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
    """The motor loses its steps and stands, while the controller goes on counting."""

    kind: Literal["stall"]
    """Tells this table from the others."""

    nth: Number = 1
    """Number of the move, from 1."""

    after: Annotated[float, Field(ge=0, lt=1)] = 0.5
    """Part of the distance that is still covered."""


class LimitSticks(Frozen):
    """A limit switch that was reached is never released: no motion leads away from it."""

    kind: Literal["limit-sticks"]
    """Tells this table from the others."""


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


StageFault: TypeAlias = Annotated[
    LostReply | CorruptedByte | LateCompletion | DuplicatedCompletion | Mute | Stall | LimitSticks | PortVanishes,
    Field(discriminator="kind"),
]
"""Something that goes wrong on this controller."""


class ControllerSettings(Frozen):
    """What both dialects share: the mechanics, the line, and how the box behaves while something moves."""

    axis: Literal["X", "Y", "Z", "T"] = "X"
    """The axis that carries the object."""

    lead_mm: LengthMm = 4.0
    """Lead of the screw [U]: 4 or 5 mm are equally plausible, so this is an assumption."""

    lead_error: Annotated[float, Field(gt=-0.1, lt=0.1)] = 0.0
    """Relative error of the true lead: the carriage goes (1 + error) times as far as the pulses say [U]."""

    backlash_mm: Level = 0.0
    """Turn of the screw that is lost at each reversal, rounded to a pulse [U]: 5 to 20 um are likely."""

    microsteps: Annotated[int, Field(gt=0, le=100_000)] = 8
    """Pulses a full step, 200 full steps a turn: 8 is the factory setting of the SC300 [V]."""

    travel_mm: tuple[PlaceMm, PlaceMm] = (-200.0, 200.0)
    """Positions of the limit switches, from the home position [U]."""

    start_mm: PlaceMm = 0.0
    """Position of the carriage when power comes, from the home position. The controller calls it 0."""

    homing: Literal["direct", "negative", "positive"] = "direct"
    """Straight to an origin switch, or over the limit switch on one side [U]. Homing on a limit switch itself is
    ``negative`` with a travel that begins at 0."""

    homing_s: SomeSeconds | None = None
    """Time that homing takes, in seconds; None: by its distance and speed [U]."""

    baud: Number = 19_200
    """Speed of the line [V]. A port of another speed is not understood."""

    turnaround_s: Seconds = 0.002
    """Time from the end of a command to the start of what it does and answers, in seconds [U]."""

    eeprom_s: Seconds = 0.0
    """Extra time in seconds before a command that sets something is answered, and the next taken [I]: field code waits 0.35 s."""

    echo: bool = False
    """Whether the box sends each command back first [V for SC300: it does not]."""

    stop_works_moving: bool = True
    """Whether a stop is carried out while something moves, whatever ``busy_policy`` says [U]."""

    stop_ramp: Literal["decelerate", "abrupt"] = "decelerate"
    """Manner in which a stop ends a motion [U]."""

    stop_completion: bool = True
    """Whether a stopped motion too ends with its completion line [U]."""

    faults: tuple[StageFault, ...] = ()
    """Faults, in any number."""

    @model_validator(mode="after")
    def _stands_inside(self) -> "ControllerSettings":
        low, high = self.travel_mm
        if not low <= self.start_mm <= high or not low <= 0.0 <= high or low == high:
            raise ValueError("travel_mm must be a range that holds start_mm and the home position 0")
        return self

    @property
    def pulses_per_mm(self) -> float:
        """Pulses of one millimetre of nominal lead."""
        return 200 * self.microsteps / self.lead_mm


class Mc600Settings(ControllerSettings):
    """An MC600 (ka400z.md 3B)."""

    busy_policy: Literal["mute", "queue", "answer"] = "answer"
    """Commands during a motion: dropped, carried out afterwards, or answered at once [I]."""

    strict_lf: bool = False
    """Whether a line feed in a command is an error. Otherwise it is passed over."""

    unit: Literal["m", "u", "s", "d"] = "m"
    """Unit of every axis when power comes: mm, um, pulses or degrees [U]."""

    speed_mm_s: LengthMm = 5.0
    """Speed when power comes [U]; a field value."""

    initial_speed_mm_s: LengthMm = 2.0
    """Initial speed when power comes [U]; a field value."""

    acceleration_mm_s2: LengthMm = 10.0
    """Acceleration when power comes [U]; a field value."""

    home_speed_mm_s: LengthMm = 4.0
    """Homing speed when power comes [U]; a field value."""

    decimals: Annotated[int, Field(ge=0, le=6)] = 3
    """Digits after the point in mm and degrees; one in um and pulses [I]."""

    completion: str = "{axis} {position},OK"
    """The unsolicited line at the end of a motion [V]."""

    stop_reply: Literal["OK", "READY", ""] = "OK"
    """Answer to ``Stop``; empty: none [U]."""

    soft_limit: Literal["refuse", "clip"] = "refuse"
    """A target beyond a soft limit that is switched on: an error, or a shorter move [U]."""

    error_syntax: str = "E01"
    """Answer to what it does not understand [U meaning]."""

    error_refused: str = "E02"
    """Answer to what it cannot do now: moving, or at a limit [U meaning]."""


class Sc300Settings(ControllerSettings):
    """An SC300 (ka400z.md 3A)."""

    busy_policy: Literal["mute", "queue", "answer"] = "mute"
    """Commands during a motion: dropped, carried out afterwards, or answered at once [I]."""

    strict_lf: bool = True
    """Whether a line feed in a command is an error: a real SC300 must not get one [V]. Otherwise it is passed over."""

    axes: Literal["X", "XY", "XYZ"] = "X"
    """Axes of the box: an SC300-1x, -2x or -3x."""

    version: str = "SC300_V1.0"
    """Answer to ``VE`` [V]."""

    speed_pps: Number = 8000
    """Top speed when power comes, pulses a second [U]."""

    initial_speed_pps: Number = 1000
    """Initial speed when power comes [U]."""

    zero_initial_speed: bool = True
    """Whether an initial speed of 0 is taken, a plain ramp from standstill [U]."""

    acceleration_pps2: Number = 16_000
    """Acceleration when power comes [U]; the unit is inferred."""

    home_speed_pps: Number = 4000
    """Speed of homing, in pulses a second [U]."""

    completion_first: Literal["?", "echo"] = "?"
    """First byte of the completion line: a question mark, or the first letter of the command [U]."""

    zero_move_completes: bool = False
    """Whether a move of length 0 gives a completion line [I: no]."""

    stop_reply: Literal["", "OK"] = ""
    """Answer to ``SPX`` before the completion line; empty: the completion line, or the position, is the answer [U]."""

    error_command: str = "ER"
    """Answer to a command that it does not know [V token, U meaning]."""

    error_parameter: str = "E0"
    """Answer to a parameter that it does not understand [V token, U meaning]."""

    error_refused: str = "E1"
    """Answer to what it cannot do now [V token, U meaning]."""
