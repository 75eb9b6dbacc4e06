"""Faults of the NI counter (h10682-daq.md 4.4, 4.5 and 12)."""

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

_READING: Final[dict[int, ErrorType]] = {
    -200279: CounterOverrun,
    -200222: CounterOverrun,
    -200278: DeviceRefused,
    -200361: CounterOverrun,
    -200010: CounterOverrun,
    -209829: CounterOverrun,
    -200141: CounterOverrun,
    -201314: TimingFault,
    -201313: DeviceRefused,
    -200140: DeviceRefused,
    -200313: TimingFault,
    -200314: TimingFault,
    -200220: DriverUnavailable,
    -201003: DeviceDisconnected,
    -200324: DeviceDisconnected,
    -200474: DeviceTimeout,
    -200560: DeviceTimeout,
    -88709: DeviceDisconnected,
    -88710: DeviceDisconnected,
    -4711: DeviceRefused,
}

_STARTING: Final[dict[int, ErrorType]] = {
    -200303: DeviceRefused,
    -200145: DeviceRefused,
    -200147: DeviceRefused,
    -200170: DriverUnavailable,
    -200022: DeviceBusy,
    -50103: DeviceBusy,
    -89137: DeviceBusy,
    -89136: DeviceRefused,
    -89120: DeviceRefused,
    -200077: DeviceRefused,
    -200089: DeviceRefused,
    -201025: DeviceRefused,
}


def _fault(line: str) -> str:
    return f"faults = [{{ {line} }}]"


def _rows() -> Iterator[Row]:
    for code, error in _READING.items():
        yield Row(
            fault=f"reading sample 101 gives {code}",
            counter="ni",
            emulator=_fault(f'kind = "read-error", code = {code}, at = 101'),
            error=error,
            says=("pmt", str(code)),
            kept=100,
            verdict="partial",
            again="as before" if code in (-200361, -201003) else None,
        )
    yield Row(
        fault="no sample from 101 on (-200284), though the modulator plays to its end",
        counter="ni",
        emulator=_fault('kind = "read-error", code = -200284, at = 101'),
        error=TriggerMissed,
        says=("100 of 240 patterns",),
        kept=100,
        verdict="failed",
        masked="all",
    )
    for give in ("bare", "status"):
        yield Row(
            fault=f"the error comes by another road ({give})",
            counter="ni",
            emulator=_fault(f'kind = "read-error", code = -200361, at = 101, give = "{give}"'),
            error=CounterOverrun,
            kept=100,
            verdict="partial",
        )
    yield Row(
        fault="overrun in a longer run, after counts were handed over",
        counter="ni",
        emulator=_fault('kind = "read-error", code = -200361, at = 1101'),
        frames=200,
        error=CounterOverrun,
        kept=1100,
        verdict="partial",
    )
    yield Row(
        fault="the edge counter alone breaks off",
        counter="ni",
        emulator=_fault('kind = "read-error", code = -200361, at = 97, counter = "ctr1"'),
        says=("the board's own memory full", "-200361"),
        verdict="flagged",
        masked=tuple(range(16, 40)),
    )
    yield Row(
        fault="a read ends before its time (-200284), once",
        counter="ni",
        emulator=_fault('kind = "short-read", at = 101'),
    )
    yield Row(
        fault="a read of the edge counter ends before its time, once",
        counter="ni",
        emulator=_fault('kind = "short-read", at = 101, counter = "ctr1"'),
    )
    for code in (-201003, -200324):
        yield Row(
            fault=f"unplugged ({code})",
            counter="ni",
            emulator=_fault(f'kind = "unplug", at = 1101, code = {code}'),
            frames=200,
            error=DeviceDisconnected,
            says=("pmt", str(code), "cable"),
            kept=998,
            verdict="partial",
            again=DeviceDisconnected,
        )
    yield Row(
        fault="the server vanishes",
        counter="ni",
        emulator=_fault('kind = "server-vanishes", at = 1101'),
        frames=200,
        error=DeviceDisconnected,
        says=("pmt", "UNAVAILABLE", "server"),
        kept=998,
        verdict="partial",
        again=DeviceDisconnected,
    )
    for counter, code in (("ctr0", -50103), ("ctr1", -200022)):
        yield Row(
            fault=f"somebody else has {counter} ({code})",
            counter="ni",
            emulator=_fault(f'kind = "held", counter = "{counter}", code = {code}'),
            error=DeviceBusy,
            says=("pmt", str(code), "close the other program"),
            kept=0,
        )
    for code, error in _STARTING.items():
        yield Row(
            fault=f"starting gives {code}, once",
            counter="ni",
            emulator=_fault(f'kind = "call", rpc = "StartTask", code = {code}'),
            error=error,
            says=("pmt", str(code)),
            kept=0,
            again="good" if code in (-200022, -89136) else None,
        )
    yield Row(
        fault="a call takes five seconds",
        counter="ni",
        emulator=_fault('kind = "call", rpc = "StartTask", delay_s = 5.0'),
        again="good",
    )
    yield Row(
        fault="duplicate-count prevention off, so that bins without photons are not stored",
        counter="ni",
        keys="prevent_duplicates = false",
        error=TimingFault,
        says=("pmt", "for 241 of the edge counter", "prevent_duplicates = true"),
        kept=232,
        verdict="failed",
        masked="all",
    )
    yield Row(
        fault="the first edge gives no sample",
        counter="ni",
        emulator="first_edge_sampled = false",
        error=TriggerMissed,
        says=("239 of 240 patterns",),
        kept=239,
        verdict="failed",
        masked="all",
    )
    yield Row(
        fault="the board doubts two samples",
        counter="ni",
        emulator="possibly_invalid_samples = 2",
        says=("2 samples possibly invalid",),
    )
    yield Row(
        fault="two edges too close for the board (-201314)",
        counter="ni",
        emulator="min_sample_gap_s = 1e-5",
        scene='faults = [{ kind = "double-edge", picture = 100 }]',
        error=TimingFault,
        says=("-201314", "oscilloscope"),
        kept=100,
        verdict="partial",
    )
    for what, emulator, keys in (
        ("the sync cable is on another line", 'sync_line = "PFI3"', ""),
        ("the sync filter is longer than the pulse", "", "sync_filter_s = 2e-5"),
    ):
        yield Row(
            fault=what,
            counter="ni",
            emulator=emulator,
            keys=keys,
            error=TriggerMissed,
            says=("pmt", "0 of 240 patterns", "sync cable"),
            kept=0,
        )
    for what, emulator in (
        ("the photon cable is on another line", 'photon_line = "PFI3"'),
        ("the photon pulses are too short for the board", "min_source_pulse_s = 1.6e-8"),
    ):
        yield Row(
            fault=what,
            counter="ni",
            emulator=emulator,
            says=("not one photon in the whole run",),
            verdict="failed",
            masked="all",
        )
    yield Row(
        fault="a line that cannot be routed (-89136)",
        counter="ni",
        emulator='unroutable = ["PFI9"]',
        error=DeviceRefused,
        says=("pmt", "-89136", "PFI line"),
        kept=0,
    )
    yield Row(
        fault="a timebase that the board does not have (-89120)",
        counter="ni",
        keys='timebase = "1GHzTimebase"',
        error=DeviceRefused,
        says=("pmt", "-89120"),
        kept=0,
    )
    yield Row(
        fault="the board's crystal is 200 ppm fast",
        counter="ni",
        emulator="timebase_ppm = 200",
        says=("+200 ppm",),
    )
    for what, emulator, error, says in (
        ("no such board (-200220)", 'devices = ["Dev2"]', DriverUnavailable, "-200220"),
        ("counters of 24 bits", "ci_max_size = 24", DeviceRefused, "24-bit counters"),
        ("counters without a sample clock", "ci_samp_clk_supported = false", DeviceRefused, "cannot be sampled"),
    ):
        yield Row(fault=what, counter="ni", emulator=emulator, at_opening=True, error=error, says=("pmt", says), kept=0)


ROWS: Final = tuple(_rows())
