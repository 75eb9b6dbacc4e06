"""The ``[counter.emulator]`` table of an emulated NI board: what the sheet leaves open, and what shall go wrong."""

from typing import Annotated, Final, Literal, TypeAlias

from pydantic import Field

from protocols import Frozen
from sim_backends.bench.bounds import ErrorCode, Hertz, Index, Instant, LaidOut, Number, Seconds, Signed, SomeSeconds

UInt32: TypeAlias = Annotated[int, Field(ge=0, lt=2**32)]


class ReadFault(Frozen):
    """The acquisition breaks before a sample: that one never comes, and a read that wants it gets an error (4.5)."""

    kind: Literal["read-error"]
    """Tells this table from the others."""

    code: ErrorCode
    """Any DAQmx error. Host overrun -200279, -200222; device overrun -200361, -200010, -209829, -200141; glitchy sync
    -201314; sync signal -200313, -200314; configuration -201313, -200140; reserved -50103, -200022; and so on."""

    at: Index
    """Index of the sample, from 0."""

    give: Literal["metadata", "bare", "status"] = "metadata"
    """Manner in which the server tells: ``ni-error`` with ``ni-samps-per-chan-read`` 0, ``ni-error`` alone, or in the status of a
    response that carries the good samples."""

    counter: str | None = None
    """Only on this counter, such as ``ctr1``; None: on each."""


class ShortRead(Frozen):
    """Once, a read across a sample ends before it as if its time were over: -200284 with the samples so far."""

    kind: Literal["short-read"]
    """Tells this table from the others."""

    at: Index
    """First sample that is held back, from 0."""

    counter: str | None = None
    """Only on this counter; None: on each."""


class LatchRace(Frozen):
    """A sample is latched too early by some counts, which the next bin gets."""

    kind: Literal["latch-race"]
    """Tells this table from the others."""

    at: Index
    """Index of the sample, from 0."""

    counts: Signed = 1
    """Number of counts that move to the later bin; negative: to the earlier one."""


class Unplugged(Frozen):
    """The board is gone from a sample on: every call about it fails."""

    kind: Literal["unplug"]
    """Tells this table from the others."""

    at: Index
    """First sample that does not come, from 0."""

    code: ErrorCode = -201003
    """-201003, -200324 or -200220: boards differ."""


class ServerVanishes(Frozen):
    """The gRPC server dies: a read that wants this sample, and every later call, finds nobody."""

    kind: Literal["server-vanishes"]
    """Tells this table from the others."""

    at: Index
    """First sample that does not come, from 0."""


class CallFault(Frozen):
    """One call fails, or is slow."""

    kind: Literal["call"]
    """Tells this table from the others."""

    rpc: str
    """Name of the remote call, such as ``StartTask``."""

    nth: Number = 1
    """Number of the call of that name, from 1."""

    code: Annotated[int, Field(ge=-(2**31), le=0)] = 0
    """DAQmx error that it gives; 0: none, it is only slow."""

    delay_s: Seconds = 0.0
    """Time that passes before the answer."""


class Held(Frozen):
    """Another program holds a counter."""

    kind: Literal["held"]
    """Tells this table from the others."""

    counter: str = "ctr0"
    """Name of the counter."""

    code: ErrorCode = -50103
    """-50103 or -200022, both are seen."""


NiFault: TypeAlias = Annotated[
    ReadFault | ShortRead | LatchRace | Unplugged | ServerVanishes | CallFault | Held, Field(discriminator="kind")
]
"""Something that goes wrong on this board."""


BUSES: Final = {"PCIe": (13612, 10054), "PXIe": (14706, 10054), "USB": (12586, 12590)}
"""Bus type of a board, and how its counter data travel: by DMA, or in USB bulk transfers (``nidaqmx.constants``)."""


class NiEmulatorSettings(Frozen):
    """An X-series board behind a gRPC device server. Marks as in the sheet: [I] inferred, [R] recalled, [U] unknown."""

    devices: tuple[str, ...] = ("Dev1",)
    """Names of the boards."""

    product_type: str = "PCIe-6321"
    """Name of the product, as ``Device.product_type`` tells it."""

    product_number: Index = 0x74A5
    """The board's hardware number, as told [U]."""

    product_category: Index = 15858
    """15858 is "X Series DAQ", 14643 "M Series DAQ"."""

    bus: Literal["PCIe", "PXIe", "USB"] = "PCIe"
    """Bus that the board is on. It decides the bus type told, and how counter data travel."""

    driver_version: tuple[Index, Index, Index] = (24, 8, 0)
    """Major, minor, update. From 24.5 on the client asks for READ_ALL_AVAILABLE in another way."""

    is_simulated: bool = False
    """What ``Device.is_simulated`` tells. NI's own simulated boards count nothing, so that a driver may refuse them."""

    counters: Annotated[int, Field(gt=0, le=64)] = 4
    """Number of counters on a board."""

    ci_max_size: Annotated[int, Field(gt=0, le=64)] = 32
    """Counter width in bits, as told; samples are 32 bits."""

    ci_max_timebase_hz: Hertz = 100e6
    """Fastest onboard timebase, as told; a faster timebase terminal does not exist."""

    ci_samp_clk_supported: bool = True
    """Whether counters take a sample clock; otherwise -200077."""

    arm_start_supported: bool = True
    """Whether ``ci_trig_usage`` has arm start (a USB-6421's manual has none)."""

    photon_line: str | None = "PFI8"
    """The terminal that the head's cable is on (NI's example: PFI8); others count nothing. None: any PFI."""

    sync_line: str | None = "PFI9"
    """The terminal that the modulator's sync is on (NI's example: PFI9); others never clock. None: any PFI."""

    start_line: str | None = None
    """A terminal with a sequence-start line, which rises with the first edge of a projection."""

    unroutable: tuple[str, ...] = ()
    """Terminals that the board cannot route to a counter: -89136."""

    first_edge_sampled: bool = True
    """Whether the first edge after a software start gives a sample [U: loopback tells]."""

    arm_edge_sampled: bool = False
    """Whether an edge that arms the counter is itself a sample: a race in the device [I]."""

    counts_before_first_edge: Index = 3
    """Photons between arming and the first edge, which sample 0 holds: dark counts and stray light [I]."""

    dup_count_prevention: bool = True
    """Default of duplicate count prevention. Without it a sample with no photon since the last edge is not written [V]."""

    min_source_pulse_s: Instant = 6.2e-9
    """Narrowest pulse that the source counts (cDAQ-9172: 6.2 ns, in its external mode 16 ns) [U for X series]."""

    merge_within_s: Instant = 0.0
    """Two photons closer than this are one source edge (with duplicate count prevention four periods of the timebase: 40 ns on
    an X series). It comes on top of the dead time that the scene's light has lost already."""

    photon_pulse_s: Instant = 10e-9
    """Width of the head's pulse [S]."""

    sync_pulse_s: Instant = 10e-6
    """Width of the modulator's sync pulse: a clock filter that is longer hides every edge."""

    min_sample_gap_s: Instant = 0.0
    """Two edges closer than this give -201314 [U]."""

    timebase_phase: Annotated[float, Field(ge=0, lt=1)] = 0.5
    """Part of a tick that has passed when the counter is armed."""

    timebase_ppm: Annotated[float, Field(ge=-1e5, le=1e5)] = 0.0
    """Parts per million by which the onboard crystal is fast against the bench's clock."""

    default_buffers: tuple[tuple[Hertz, LaidOut], ...] = ((100.0, 1000), (10e3, 10_000), (1e6, 100_000))
    """Input buffer of a continuous task, in samples, up to a rate in Hz [R]; faster: one million."""

    readable_after_overrun: bool = False
    """Whether samples that wait in the buffer can still be read after -200222 [U]."""

    possibly_invalid_samples: Index = 0
    """Number of samples that ``ci_num_possibly_invalid_samps`` tells."""

    patience_s: SomeSeconds = 3600.0
    """A wait without limit ends after this long, instead of never."""

    faults: tuple[NiFault, ...] = ()
    """Faults, in any number."""
