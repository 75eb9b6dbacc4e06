"""Faults of the USB-CTR (h10682-daq.md 5 and 12)."""

from collections.abc import Iterator
from typing import Final

from protocols import (
    CounterOverrun,
    DeviceBusy,
    DeviceDisconnected,
    DeviceRefused,
    DeviceTimeout,
    DriverUnavailable,
    TimingFault,
    TriggerMissed,
)
from tests.faults.row import ErrorType, Row

_TIMER: Final = "edge_timer = { timer = 1, counter = 1 }"
_SYNC: Final = "sync_counter = 2"
_WIRE: Final = "timer_wires = [{ timer = 1, counter = 1 }]\n"

_REQUESTS: Final = {
    0x18: "COUNTER_PARAMETERS",
    0x20: "SCAN_CONFIG",
    0x21: "SCAN_START",
    0x22: "SCAN_STOP",
    0x23: "SCAN_CLEAR_FIFO",
}
_OPENING: Final = {0x40: "STATUS", 0x48: "SERIAL", 0x52: "FPGA_VERSION"}
_FAILURES: Final[dict[str, ErrorType]] = {"stall": DeviceRefused, "timeout": DeviceTimeout}


def _fault(line: str) -> str:
    return f"faults = [{{ {line} }}]"


def _at_opening(fault: str, emulator: str, error: ErrorType, *says: str, keys: str = "") -> Row:
    return Row(
        fault=fault,
        counter="usb-ctr",
        keys=keys,
        emulator=emulator,
        at_opening=True,
        error=error,
        says=("pmt", *says),
        kept=0,
    )


def _rows() -> Iterator[Row]:
    for how in ("stall", "silent"):
        emulator = f'fpga_configured = false\nunconfigured = "{how}"'
        yield _at_opening(
            f"the FPGA is not configured ({how})", emulator, DriverUnavailable, "without its FPGA image", "fpga_image"
        )
    yield _at_opening(
        "the FPGA does not take the image",
        "fpga_configured = false\n" + _fault('kind = "fpga-refused"'),
        DeviceRefused,
        "not configured after image.rbf",
        keys='fpga_image = "image.rbf"',
    )
    yield _at_opening(
        "no right to use the board", _fault('kind = "no-permission"'), DriverUnavailable, "EACCES", "udev"
    )
    yield _at_opening(
        "another program uses the board", _fault('kind = "interface-claimed"'), DeviceBusy, "EBUSY", "other program"
    )
    yield _at_opening(
        "the maker's driver holds the board (Windows)", _fault('kind = "maker-driver"'), DriverUnavailable, "Zadig"
    )
    for number, name in _OPENING.items():
        for failure, error in _FAILURES.items():
            emulator = _fault(f'kind = "control", request = {number}, error = "{failure}"')
            yield _at_opening(f"{name} at opening: {failure}", emulator, error, name)
    for number, name in _REQUESTS.items():
        for failure, error in _FAILURES.items():
            yield Row(
                fault=f"{name}: {failure}, once",
                counter="usb-ctr",
                emulator=_fault(f'kind = "control", request = {number}, error = "{failure}"'),
                error=error,
                says=("pmt", name),
                kept=0,
                again="good",
            )
    yield Row(
        fault="BULK_FLUSH after the run: stall, once",
        counter="usb-ctr",
        emulator=_fault('kind = "control", request = 0x24, error = "stall"'),
        says=("while disarming", "BULK_FLUSH"),
        again="good",
    )
    yield Row(
        fault="a request takes five seconds",
        counter="usb-ctr",
        emulator=_fault('kind = "control", request = 0x40, nth = 3, error = "none", delay_s = 5.0'),
        again="good",
    )
    for kind in ("overrun", "pacer-overrun"):
        yield Row(
            fault=f"the board overruns ({kind})",
            counter="usb-ctr",
            emulator=_fault(f'kind = "{kind}", at = 101'),
            error=CounterOverrun,
            says=("pmt", "after 101 samples", "USB port"),
            kept=100,
            verdict="partial",
        )
    yield Row(
        fault="the board overruns in a longer run",
        counter="usb-ctr",
        emulator=_fault('kind = "overrun", at = 1101'),
        frames=200,
        error=CounterOverrun,
        kept=1100,
        verdict="partial",
    )
    yield Row(
        fault="edges come faster than the board can scan",
        counter="usb-ctr",
        emulator="max_words_per_s = 1e4",
        error=CounterOverrun,
        says=("pmt", "lower pattern_rate_hz"),
        kept=0,
    )
    for at, frames in ((101, 40), (1101, 400)):
        yield Row(
            fault=f"unplugged at sample {at}",
            counter="usb-ctr",
            emulator=_fault(f'kind = "disconnect", at = {at}'),
            frames=frames,
            error=DeviceDisconnected,
            says=("pmt", "ENODEV", "cable"),
            kept=at - 1,
            verdict="partial",
            again=DeviceDisconnected,
        )
    yield Row(
        fault="a packet comes in two parts, of which one is half a sample",
        counter="usb-ctr",
        keys=_TIMER,
        emulator=_WIRE + _fault('kind = "short-packet", at = 101'),
    )
    yield Row(
        fault="an empty packet in mid-run",
        counter="usb-ctr",
        emulator=_fault('kind = "zero-length-packet", at = 101'),
    )
    yield from _full_packets()
    yield Row(fault="the last partial packet is withheld", counter="usb-ctr", emulator="flush_at_end = false")
    yield Row(fault="no zero-length packet at the end", counter="usb-ctr", emulator='zero_length_packet = "never"')
    yield Row(fault="a full-speed bus", counter="usb-ctr", emulator="high_speed = false")
    for board, driver in (("0x20", "0x40"), ("0x40", "0x20")):
        yield Row(
            fault=f"scan done is status bit {board}, and the driver looks at {driver}",
            counter="usb-ctr",
            keys=f"scan_done_mask = {driver}",
            emulator=f"scan_done_mask = {board}",
        )
    yield Row(
        fault="the board takes a sample at the start of the scan too: all bins shift",
        counter="usb-ctr",
        emulator="reads_at_start = true",
        says=("1 surplus sync edges and no edge times",),
        verdict="failed",
        masked="all",
    )
    yield Row(
        fault="the edge timer is not wired",
        counter="usb-ctr",
        keys=_TIMER,
        frames=200,
        error=TimingFault,
        kept=1000,
        says=("pmt", "without a tick", "wire the timer"),
        verdict="partial",
    )
    for what, keys, emulator in (
        ("the debounce code is not the one that means off", "", 'debounce_table = "wjasper"'),
        ("the debounce code is that of the other source", "debounce_code = 0", ""),
        ("the photon pulses are too short for the board", "", "min_pulse_s = 1.04e-8"),
    ):
        yield Row(
            fault=what,
            counter="usb-ctr",
            keys=keys,
            emulator=emulator,
            says=("not one photon in the whole run",),
            verdict="failed",
            masked="all",
        )


def _full_packets() -> Iterator[Row]:
    yield Row(fault="the sync is wired to a counter too: full packets", counter="usb-ctr", keys=_SYNC, emulator=_SYNC)
    yield Row(
        fault="full packets, and the board takes a sample at the start of the scan too",
        counter="usb-ctr",
        keys=_SYNC,
        emulator=_SYNC + "\nreads_at_start = true",
        error=TimingFault,
        says=("pmt", "set first_samples = 2"),
        kept=0,
    )
    yield Row(
        fault="full packets, and the board overruns",
        counter="usb-ctr",
        keys=_SYNC,
        emulator=_SYNC + "\n" + _fault('kind = "overrun", at = 601'),
        frames=200,
        error=CounterOverrun,
        says=("pmt", "after 512 samples"),
        kept=511,
        verdict="partial",
    )
    yield Row(
        fault="full packets, and the last partial one is withheld",
        counter="usb-ctr",
        keys=_SYNC,
        emulator=_SYNC + "\nflush_at_end = false",
        frames=200,
        error=TimingFault,
        says=("pmt", "a scan that ended by itself"),
        kept=1023,
        verdict="partial",
    )
    yield Row(
        fault="full packets, and one edge is lost: the board keeps the last packet",
        counter="usb-ctr",
        keys=_SYNC,
        emulator=_SYNC,
        scene='faults = [{ kind = "drop-edge", picture = 700 }]',
        frames=200,
        error=TriggerMissed,
        says=("pmt",),
        kept=1023,
        verdict="failed",
        masked="all",
    )


ROWS: Final = tuple(_rows())
