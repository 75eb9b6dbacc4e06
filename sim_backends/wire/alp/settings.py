"""The ``[modulator.emulator]`` table: what the sheet leaves open about a V-7000, and what shall go wrong."""

from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, field_validator

from protocols import Frozen
from sim_backends.bench.bounds import Hertz, Index, LaidOut, Level, Microseconds, Number, Signed, SomeSeconds
from sim_backends.wire.alp.codes import FUNCTIONS


class CallFault(Frozen):
    """A call that fails (dlp7000.md 8)."""

    kind: Literal["unplug", "power-loss", "other-owner", "memory-full", "halt-during-put", "refuse"]
    """``unplug``: 1012 from this call on. ``power-loss``: 1001 from this call on. ``other-owner``: AlpDevAlloc gives
    1004. ``memory-full``: AlpSeqAlloc gives 1007. ``halt-during-put``: AlpSeqPut is aborted half-way with 1009, as by an
    AlpDevHalt from elsewhere. ``refuse``: this one call gives ``code``."""

    at: str = ""
    """Name of the C function; empty: the function that the kind is about, AlpDevAlloc for the first two."""

    nth: Number = 1
    """Number of the call of that function, from 1."""

    code: Number = 1999
    """Code that ``refuse`` gives: any at all. A driver has to take each of them."""

    @field_validator("at")
    @classmethod
    def _is_a_function(cls, name: str) -> str:
        if name and name not in FUNCTIONS:
            raise ValueError(f"no such function; there are {', '.join(sorted(FUNCTIONS))}")
        return name

    @property
    def function(self) -> str:
        """Name of the C function that fails."""
        usual = {"memory-full": "AlpSeqAlloc", "halt-during-put": "AlpSeqPut"}
        return self.at or usual.get(self.kind, "AlpDevAlloc")


class NoDmd(Frozen):
    """The DMD's ribbon cable is off: the type reads 255 and the geometry that of a 1080p array (dlp7000.md 3.4)."""

    kind: Literal["no-dmd"]
    """Tells this table from the others."""


class LostFrames(Frozen):
    """Pictures that are never shown and give no edge, without any error code: the realistic silent failure."""

    kind: Literal["lost-frames"]
    """Tells this table from the others."""

    first: Index
    """First lost picture of a projection, from 0."""

    count: LaidOut = 1
    """Number of times."""

    slots: Literal["pass", "close-up"] = "pass"
    """Whether their time passes, with the picture before them still on the mirrors, or the next picture comes at once [U]."""


class WrongRows(Frozen):
    """Every picture comes some rows too low, as after a row-address error; the last rows come back at the top."""

    kind: Literal["wrong-rows"]
    """Tells this table from the others."""

    rows: Signed = 1
    """Number of rows of the shift; negative is up."""


AlpFault: TypeAlias = Annotated[CallFault | NoDmd | LostFrames | WrongRows, Field(discriminator="kind")]
"""Something that goes wrong on this board."""


class AlpEmulatorSettings(Frozen):
    """A V-7000 as far as the sheet knows it. Marks: [V] verified, [S] second-hand, [I] inferred, [U] unknown."""

    serial_number: Number = 10001
    """What ALP_DEVICE_NUMBER tells and AlpDevAlloc takes beside 0."""

    version: Number = 0x0403
    """ALP_VERSION. [S] 0x0401 was seen on a 4.1 library; this one is by analogy."""

    dmd_type: Number = 4
    """ALP_DEV_DMDTYPE: 4 is a DLP7000 [V]."""

    memory_frames: Number = 43_690
    """Binary pictures on the board [S]."""

    min_picture_time_us: Microseconds = 44
    """Shortest picture of the full array, 1 bit, uninterrupted [S]."""

    row_load_us: Level = 0.04
    """Time by which a picture may be shorter for each row that ALP_SEQ_DMD_LINES leaves out, in microseconds [I]."""

    min_dark_us: Microseconds = 44
    """Shortest dark phase in ALP_BIN_NORMAL [S]."""

    max_picture_time_us: Microseconds = 10_000_000
    """Longest picture time, in microseconds [V]."""

    max_synch_delay_us: Microseconds = 130_000
    """Longest delay from synch to display [V]."""

    max_trigger_in_delay_us: Microseconds = 130_000
    """Longest delay from trigger input to display [U]."""

    default_picture_time_us: Microseconds = 33_334
    """Where neither picture nor illuminate time is given: 30 Hz, 33,333 or 33,334 us [V]."""

    max_repeat: Number = 1_048_576
    """Most iterations of a finite projection [S]."""

    flut_max_entries9: Index = 32_768
    """ALP_FLUT_MAX_ENTRIES9 [U]. 0: a board without frame look-up table, which answers 1005."""

    flut_18bit: bool = True
    """Whether 18-bit entries work [V for ALP-4.1 and later headers, U for this board]."""

    flut_write_unit: Literal["entries", "slots9"] = "entries"
    """What ``nOffset`` of ALP_FLUT_WRITE_18BIT counts: entries of 18 bit or slots of 9 bit [U]."""

    timing_violation_code: Number = 1005
    """Answer to a timing that cannot be kept [S]."""

    unknown_device_code: Number = 1003
    """Answer to a device id that is not valid [I]."""

    unknown_sequence_code: Number = 1006
    """Answer to a sequence id that is not valid [S]."""

    free_needs_halt: bool = True
    """Whether AlpDevFree gives 1002 after a projection until AlpDevHalt was called ([V] that it needs the idle state; [I]
    that a projection that ended by itself leaves another one)."""

    start_latency_us: Level = 200.0
    """Time from AlpProjStart to the first edge or picture, in microseconds [U]."""

    first_synch: Literal["with-picture-0", "extra", "missing"] = "with-picture-0"
    """Whether a run of N pictures gives N synch pulses from picture 0 on, one more before it, or none for picture 0 [U]."""

    uploads_cleared: bool = True
    """Whether a picture that was never uploaded is dark; otherwise every second mirror is on [U]."""

    usb_bytes_per_s: Hertz = 30e6
    """Speed of AlpSeqPut: 25 to 35 MB/s on USB 2 [I]."""

    endless_pictures: LaidOut = 200_000
    """Number of pictures of an endless or much repeated projection that are laid out on the optical bench."""

    queue_positions: Number = 16
    """Sequences that may wait in ALP_PROJ_SEQUENCE_QUEUE [U]. In legacy mode one may [V]."""

    full_queue_code: Number = 1002
    """Answer to a start where no position is free [U]."""

    reallocation_s: Level = 0.0
    """Time after AlpDevFree within which AlpDevAlloc gives ``reallocation_code``."""

    reallocation_code: Number = 1001
    """Answer to an allocation that comes too early: 1001, 1011 and 1012 were seen [S]."""

    owner_file: Path | None = None
    """A file that stands for the board's memory of its owner: it is there while the board is allocated, and AlpDevAlloc gives
    1004 while it is. Who is killed leaves it behind; deleting it is the power cycle. Relative to bench.toml."""

    patience_s: SomeSeconds = 3600.0
    """AlpProjWait on a projection that never ends comes back after this long with 1999, instead of never."""

    faults: tuple[AlpFault, ...] = ()
    """Faults, in any number."""
