"""The ``[counter.emulator]`` table of ``transport = "serial-counter-emulator"``."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from protocols import Frozen
from sim_backends.bench.bounds import Index, LaidOut, Number, Seconds


class LostLine(Frozen):
    """The line of a bin never arrives."""

    kind: Literal["lost-line"]
    """Tells this table from the others."""

    bin: Index
    """Index of the bin."""


class CorruptedLine(Frozen):
    """The line of a bin arrives with one wrong byte."""

    kind: Literal["corrupted-line"]
    """Tells this table from the others."""

    bin: Index
    """Index of the bin."""


class Unplugged(Frozen):
    """The port is gone from a bin on."""

    kind: Literal["unplugged"]
    """Tells this table from the others."""

    bin: Index
    """Index of the first bin that is lost."""


class Mute(Frozen):
    """The firmware hangs: no answer from a command on."""

    kind: Literal["mute"]
    """Tells this table from the others."""

    nth: Number = 1
    """Number of the command, from 1."""


CounterFault: TypeAlias = Annotated[LostLine | CorruptedLine | Unplugged | Mute, Field(discriminator="kind")]
"""Something that goes wrong on this counter."""


class SerialCounterEmulatorSettings(Frozen):
    """One counter on the optical bench."""

    model: str = "emulated counter"
    """Model, as ``id`` tells it."""

    baud: Number = 12_000_000
    """Speed of the line: that of USB. At another one nothing is understood."""

    ticks_hz: Annotated[int, Field(gt=0, le=1_000_000_000)] = 125_000_000
    """Rate of its clock: a Pico's."""

    memory_bytes: LaidOut = 65_536
    """Bytes that may wait for the line; when there are more, it says ``overrun``."""

    turnaround_s: Seconds = 0.0005
    """Time from the end of a command to its answer, in seconds."""

    pty: bool = False
    """Whether the port is a pseudo-terminal of this computer instead of an object; wants ``realtime = true`` in [scene]."""

    faults: tuple[CounterFault, ...] = ()
    """Faults, in any number."""
