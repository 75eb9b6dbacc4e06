"""Faults of the DLP7000's board (dlp7000.md 8 and 3.3)."""

from collections.abc import Iterator
from typing import Final

from protocols import (
    DeviceBusy,
    DeviceDisconnected,
    DeviceError,
    DeviceRefused,
    DriverUnavailable,
    InputError,
    PatternMemoryFull,
    SafeStateFailed,
    TriggerMissed,
    WrongState,
)
from tests.faults.row import ErrorType, Row


def _fault(line: str) -> str:
    return f"faults = [{{ {line} }}]"


def _at_opening(fault: str, line: str, error: ErrorType, *says: str) -> Row:
    return Row(
        fault=fault, modulator="alp", emulator=_fault(line), at_opening=True, error=error, says=("dmd", *says), kept=0
    )


def _gone(fault: str, line: str, call: str, code: str, kept: int = 0) -> Row:
    """The board is gone, so it cannot be made safe either: that is what is raised, from the first error."""
    return Row(
        fault=fault,
        modulator="alp",
        emulator=_fault(line),
        error=SafeStateFailed,
        after=DeviceDisconnected,
        says=("modulator", call, code),
        kept=kept,
        again=SafeStateFailed,
        closing=SafeStateFailed,
    )


_OPENING_CALLS: Final = (
    "AlpDevInquire",
    "AlpDevControl",
    "AlpProjInquire",
    "AlpProjControl",
    "AlpSeqAlloc",
    "AlpSeqControl",
    "AlpSeqTiming",
    "AlpSeqInquire",
    "AlpSeqFree",
)
_LOADING_CALLS: Final = (
    ("AlpSeqAlloc", 2),
    ("AlpSeqControl", 4),
    ("AlpSeqTiming", 2),
    ("AlpSeqInquire", 4),
    ("AlpSeqPut", 1),
    ("AlpSeqPut", 2),
    ("AlpProjControlEx", 1),
    ("AlpProjStart", 1),
)

_REFUSALS: Final[dict[int, ErrorType]] = {
    1001: DeviceDisconnected,
    1002: DeviceBusy,
    1003: DeviceRefused,
    1004: DeviceBusy,
    1005: DeviceRefused,
    1006: DeviceRefused,
    1007: DeviceRefused,
    1008: DeviceBusy,
    1009: WrongState,
    1010: DeviceRefused,
    1011: DeviceDisconnected,
    1012: DeviceDisconnected,
    1013: DeviceRefused,
    1014: DriverUnavailable,
    1018: DeviceRefused,
    1019: DriverUnavailable,
    1020: DeviceRefused,
    1021: DeviceRefused,
    1999: DeviceRefused,
    4711: DeviceRefused,
}


def _rows() -> Iterator[Row]:
    yield _at_opening("no board", 'kind = "unplug"', DriverUnavailable, "AlpDevAlloc", "1012")
    yield _at_opening("no power", 'kind = "power-loss"', DriverUnavailable, "AlpDevAlloc", "1001", "power")
    for code in (1001, 1011, 1012):
        yield Row(
            fault=f"the board is not there yet, a moment after it was let go of ({code})",
            modulator="alp",
            emulator=_fault(f'kind = "refuse", at = "AlpDevAlloc", code = {code}'),
        )
    yield _at_opening("somebody else has the board", 'kind = "other-owner"', DeviceBusy, "1004", "other program")
    yield _at_opening("no DMD on the board", 'kind = "no-dmd"', DriverUnavailable, "DMD type 255", "flat cable")
    yield _at_opening("no memory at all", 'kind = "memory-full"', DeviceError, "1007", "power-cycle")
    for call in _OPENING_CALLS:
        line = f'kind = "unplug", at = "{call}"'
        yield _at_opening(f"unplugged at {call}", line, DeviceDisconnected, call, "1012")
    for call, nth in _LOADING_CALLS:
        line = f'kind = "unplug", at = "{call}", nth = {nth}'
        yield _gone(f"unplugged at {call}, call {nth}", line, "AlpDevHalt", "1012")
    line = 'kind = "unplug", at = "AlpProjInquire", nth = 2'
    yield _gone("unplugged while it plays", line, "AlpDevHalt", "1012", kept=240)
    line = 'kind = "power-loss", at = "AlpProjInquire", nth = 2'
    yield _gone("power lost while it plays", line, "AlpDevHalt", "1001", kept=240)
    yield Row(
        fault="unplugged after the run",
        modulator="alp",
        emulator=_fault('kind = "unplug", at = "AlpDevFree"'),
        closing=DeviceDisconnected,
    )
    yield Row(
        fault="memory in use",
        modulator="alp",
        emulator=_fault('kind = "memory-full", nth = 2'),
        error=PatternMemoryFull,
        says=("dmd", "1007", "fewer frames"),
        kept=0,
        again="good",
    )
    yield Row(
        fault="somebody halts the board during the upload",
        modulator="alp",
        emulator=_fault('kind = "halt-during-put", nth = 2'),
        error=WrongState,
        says=("dmd", "AlpSeqPut", "1009", "load the patterns again"),
        kept=0,
        again="good",
    )
    for code, error in _REFUSALS.items():
        yield Row(
            fault=f"AlpProjStart answers {code}",
            modulator="alp",
            emulator=_fault(f'kind = "refuse", at = "AlpProjStart", code = {code}'),
            error=error,
            says=("dmd", "AlpProjStart", str(code)),
            kept=0,
            again="good" if code in (1005, 1009, 1012) else None,
        )
    yield Row(
        fault="frames lost without an error code",
        modulator="alp",
        emulator=_fault('kind = "lost-frames", first = 100, count = 3'),
        verdict="flagged",
        gaps=(100, 101, 102),
        masked=(16, 17),
        counts="alike",
    )
    yield Row(
        fault="frames lost without an error code (NI, MC600)",
        modulator="alp",
        counter="ni",
        stage="mc600",
        emulator=_fault('kind = "lost-frames", first = 100, count = 3'),
        verdict="flagged",
        gaps=(100, 101, 102),
        masked=(16, 17),
        counts="alike",
    )
    yield Row(
        fault="frames lost without an error code, and the next come at once: nothing tells which",
        modulator="alp",
        emulator=_fault('kind = "lost-frames", first = 100, count = 3, slots = "close-up"'),
        error=TriggerMissed,
        says=("pmt", "237 of 240 patterns"),
        kept=237,
        verdict="failed",
        masked="all",
    )
    yield Row(
        fault="the first sync pulse is missing",
        modulator="alp",
        emulator='first_synch = "missing"',
        error=TriggerMissed,
        says=("pmt", "239 of 240 patterns"),
        kept=239,
        verdict="failed",
        masked="all",
    )
    yield Row(
        fault="one sync pulse more before the first picture",
        modulator="alp",
        emulator='first_synch = "extra"',
        verdict="flagged",
        masked="all",
        says=("by the counts themselves, values come",),
    )
    yield Row(
        fault='trigger = "slave", in which a board without edges would wait for ever',
        modulator="alp",
        keys='trigger = "slave"',
        at_opening=True,
        error=InputError,
        says=("dmd", "slave", "without any error"),
        kept=0,
    )


ROWS: Final = tuple(_rows())
