"""The ``[counter.emulator]`` table of an emulated USB-CTR: what the sheet leaves open, and what shall go wrong."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from protocols import Frozen
from sim_backends.bench.bounds import Hertz, Index, Instant, Number, Seconds, Signed, SomeSeconds

CounterIndex: TypeAlias = Annotated[int, Field(ge=0, le=7)]
TimerIndex: TypeAlias = Annotated[int, Field(ge=0, le=3)]


class TimerWire(Frozen):
    """A wire from a timer's output to a counter's input: the on-board test source."""

    timer: TimerIndex
    """Index of the timer."""

    counter: CounterIndex
    """Index of the counter."""


class FpgaRefused(Frozen):
    """The image does not configure the FPGA."""

    kind: Literal["fpga-refused"]
    """Tells this table from the others."""


class NoAccess(Frozen):
    """The device cannot be opened (errno 13), its interface is held (errno 16), or the maker's driver holds it.

    What the maker's driver holds, libusb cannot open: NOT_SUPPORTED.
    """

    kind: Literal["no-permission", "interface-claimed", "maker-driver"]
    """Reason for which the board cannot be opened."""


class ScanFault(Frozen):
    """Something that happens at one scan."""

    kind: Literal["overrun", "pacer-overrun", "disconnect", "short-packet", "zero-length-packet"]
    """``overrun``: the FIFO overflows, scanning stops before this scan. ``pacer-overrun``: the same, as the clock was too
    fast. ``disconnect``: the device leaves the bus, errno 19 from then on. ``short-packet``: the packet with this scan
    comes in two parts (one of a single word cannot). ``zero-length-packet``: an empty packet comes before it."""

    at: Index
    """Index of the scan, from 0."""


class ClearRace(Frozen):
    """Some counts come while the counter is read and cleared: they fall into the next scan."""

    kind: Literal["clear-race"]
    """Tells this table from the others."""

    at: Index
    """The scan that loses them, from 0."""

    counts: Signed = 1
    """Number of counts; negative: the next scan loses them to this one."""


class ControlFault(Frozen):
    """One control transfer fails, or is slow."""

    kind: Literal["control"]
    """Tells this table from the others."""

    request: Annotated[int, Field(ge=0, le=255)]
    """``bRequest``, such as 0x21 for SCAN_START."""

    nth: Number = 1
    """Number of the transfer of that request, from 1."""

    error: Literal["stall", "timeout", "none"] = "stall"
    """Manner in which the transfer fails."""

    delay_s: Seconds = 0.0
    """Time that passes before the answer."""


UsbCtrFault: TypeAlias = Annotated[
    FpgaRefused | NoAccess | ScanFault | ClearRace | ControlFault, Field(discriminator="kind")
]
"""Something that goes wrong on this device."""


class UsbCtrEmulatorSettings(Frozen):
    """A USB-CTR04 or 08. Marks as in the sheet: [V] verified, [I] inferred, [U] unknown."""

    model: Literal["USB-CTR04", "USB-CTR08"] = "USB-CTR04"
    """PID 0x012E with four counters, or 0x0127 with eight [V]."""

    serial_number: Annotated[str, Field(pattern=r"^[0-9A-F]{8}$")] = "01A2B3C4"
    """Serial number of eight characters."""

    high_speed: bool = True
    """Packets of 512 bytes; otherwise, on a full-speed bus, 64 [V]."""

    photon_counter: CounterIndex = 0
    """The counter input that the head is wired to."""

    sync_counter: CounterIndex | None = None
    """A counter input that the sync is wired to as well, for counting edges or for their period."""

    timer_wires: tuple[TimerWire, ...] = ()
    """Test wires. A timer that is not enabled gives no pulse."""

    fpga_configured: bool = False
    """Whether the image is still loaded from before."""

    fpga_image_bytes: Number = 1
    """Bytes after which the FPGA is configured, whatever they are. The maker's image is longer [U]."""

    fpga_needs_zero_bytes: bool = False
    """Whether the FPGA is configured only after a transfer of two zero bytes behind the image, which the maker's library sends
    to this family; another public driver does not [U]."""

    fpga_version: Annotated[int, Field(ge=0, le=0xFFFF)] = 0x0102
    """Version of the FPGA image in BCD: 0x0102 is 01.02."""

    unconfigured: Literal["stall", "silent"] = "stall"
    """What counters, timers and scans do before the FPGA is configured: refuse, or take all and give zeros [U]."""

    debounce_table: Literal["uldaq", "wjasper"] = "uldaq"
    """Source of the codes: the debounce is off at 16 (the maker's library) or 0 (another driver). The sources disagree."""

    debounce_at_power_up: Annotated[int, Field(ge=0, le=0x3F)] = 0
    """Debounce code of every counter before one is written [U]."""

    photon_pulse_s: Instant = 10e-9
    """Width of the head's pulse [S]."""

    min_pulse_s: Instant = 0.0
    """Narrowest pulse that is counted. 48 MHz at half duty would be 10.4 ns, a little longer than the head's [U]."""

    counts_before_first_edge: Index = 3
    """Photons between the start of a scan and the first edge, which scan 0 holds: dark counts and stray light [I]."""

    reads_at_start: bool = False
    """Whether a scan is taken as soon as scanning starts, before any edge ("point 0", seen in MCS mode) [U]."""

    scan_done_mask: Annotated[int, Field(ge=0, le=0xFFFF)] = 0x20
    """Status bits of a scan that is done: 0x20 is likelier, as 0x40 belongs to output scans in the maker's library."""

    pacer_overrun_mask: Annotated[int, Field(ge=0, le=0xFFFF)] = 0x04
    """Status bits when the clock was too fast [U]."""

    zero_fill_works: bool = False
    """Whether the FPGA obeys bit 6 of a scan element; it is said to ignore it."""

    fifo_bytes: Number = 16384
    """Data that waits in the device at most: 8 x 2 x 1024 [V]."""

    max_words_per_s: Hertz = 4e6
    """Words a second at most; faster edges overrun the pacer [V]."""

    flush_at_end: bool = True
    """Whether a finite scan that is complete sends its last partial packet, where packets have 256 words; with another size
    of packet it was not seen to [S]. One that is stopped never does [V]."""

    zero_length_packet: Literal["full-packet", "total", "never"] = "full-packet"
    """When a complete scan ends with an empty packet: if its last packet was full, if its whole length is a multiple of the
    packet size, or never [U which of the first two]."""

    patience_s: SomeSeconds = 3600.0
    """A transfer without time limit ends after this long, instead of never."""

    faults: tuple[UsbCtrFault, ...] = ()
    """Faults, in any number."""
