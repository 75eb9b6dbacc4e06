"""The ``[modulator.emulator]`` table of ``transport = "dlpc900-emulator"``. Marks as in the hardware sheet."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from protocols import Frozen
from sim_backends.bench.bounds import Number, Seconds


class LostReply(Frozen):
    """A reply that never arrives. The command is carried out."""

    kind: Literal["lost-reply"]
    """Tells this table from the others."""

    command: Annotated[int, Field(ge=0, lt=65_536)]
    """Number of the command."""

    nth: Number = 1
    """Which of them, from 1."""


class WrongEcho(Frozen):
    """A reply with another sequence number."""

    kind: Literal["wrong-echo"]
    """Tells this table from the others."""

    command: Annotated[int, Field(ge=0, lt=65_536)]
    """Number of the command."""

    nth: Number = 1
    """Which of them, from 1."""


class Error(Frozen):
    """A command is refused, and not carried out."""

    kind: Literal["error"]
    """Tells this table from the others."""

    command: Annotated[int, Field(ge=0, lt=65_536)]
    """Number of the command."""

    code: Annotated[int, Field(ge=1, le=255)] = 2
    """Error number."""

    nth: Number = 1
    """Which of them, from 1."""


class LostReport(Frozen):
    """One report of the host never arrives."""

    kind: Literal["lost-report"]
    """Tells this table from the others."""

    nth: Number = 100
    """Which report, from 1."""


class Unplugged(Frozen):
    """The device is gone."""

    kind: Literal["unplugged"]
    """Tells this table from the others."""

    nth: Number = 100
    """At which report of the host, from 1."""


class Abort(Frozen):
    """The sequencer breaks off, and says so in the hardware status."""

    kind: Literal["abort"]
    """Tells this table from the others."""

    picture: Number = 100
    """Before which picture."""


Dlpc900Fault: TypeAlias = Annotated[
    LostReply | WrongEcho | Error | LostReport | Unplugged | Abort, Field(discriminator="kind")
]
"""Something that goes wrong on this board."""


class Dlpc900EmulatorSettings(Frozen):
    """One board."""

    model: Literal["DLP6500", "DLP9000", "DLP670S"] = "DLP6500"
    """Mirror array: 1920 x 1080 with one controller, 2560 x 1600 with two, or one that is not emulated beyond its name."""

    firmware: Annotated[str, Field(pattern=r"^\d{1,3}\.\d{1,3}\.\d{1,5}$")] = "6.0.2"
    """Application version."""

    report_s: Seconds = 0.0002
    """Time that a report takes, in seconds: 64 bytes each make the 20 s that a random image is said to take [I]."""

    start_delay_s: Seconds = 0.0005
    """Time from the start to the first sync edge, in seconds [U]."""

    colour_order: Literal["rgb", "grb"] = "rgb"
    """Order of a pixel's bytes: planes 0 to 7 in blue, 8 to 15 in green, 16 to 23 in red; sources differ [S]."""

    power_up_mode: Literal[0, 1] = 1
    """Display mode when power comes: the guide says 1 and 0."""

    initialized: bool = True
    """Bit 0 of the hardware status."""

    second_controller: bool = True
    """Bit 4 of the hardware status, on an array with two."""

    memory_good: bool = True
    """Bit 0 of the system status."""

    faults: tuple[Dlpc900Fault, ...] = ()
    """Faults, in any number."""
