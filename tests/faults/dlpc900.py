"""Faults of the DLPC900 and of its USB line (dlpc900.md, section 9)."""

from typing import Any, Final

from protocols import DeviceDisconnected, DeviceError, DeviceRefused, DeviceTimeout, SafeStateFailed, TriggerMissed
from tests.faults.row import Row


def _row(fault: str, line: str, **answers: object) -> Row:
    values: dict[str, Any] = {
        "fault": fault,
        "modulator": "dlpc900",
        "pattern_rate_hz": 5000.0,
        "emulator": f"faults = [{{ {line} }}]",
        **answers,
    }
    return Row(**values)


ROWS: Final = (
    _row(
        "the second controller is missing",
        "",
        emulator='model = "DLP9000"\nsecond_controller = false',
        at_opening=True,
        error=DeviceError,
        says=("dmd", "second controller is missing"),
        kept=0,
    ),
    _row(
        "the test of its memory has failed",
        "",
        emulator="memory_good = false",
        at_opening=True,
        error=DeviceError,
        says=("dmd", "memory has failed"),
        kept=0,
    ),
    _row("a reply with another number: it is asked once more", 'kind = "wrong-echo", command = 0x1A0C', again="good"),
    _row(
        "the answer to a definition is lost",
        'kind = "lost-reply", command = 0x1A34, nth = 10',
        error=DeviceTimeout,
        says=("dmd", "0x1A34"),
        kept=0,
        again="good",
    ),
    _row(
        "a definition is refused",
        'kind = "error", command = 0x1A34, code = 8, nth = 10',
        error=DeviceRefused,
        says=("dmd", "0x1A34 refused: out of memory"),
        kept=0,
        again="good",
    ),
    _row(
        "a report of an image is lost",
        'kind = "lost-report", nth = 300',
        error=DeviceRefused,
        says=("dmd", "refused"),
        kept=0,
        again="good",
    ),
    _row(
        "the start is refused",
        'kind = "error", command = 0x1A24, code = 5, nth = 5',
        error=DeviceRefused,
        says=("dmd", "0x1A24 refused: not allowed in the present mode"),
        kept=0,
        again="good",
    ),
    _row(
        "the sequencer breaks off",
        'kind = "abort", picture = 100',
        error=TriggerMissed,
        says=("pmt", "99 of 240 patterns counted"),
        kept=99,
        verdict="failed",
        masked="all",
    ),
    _row(
        "the board is unplugged during the upload",
        'kind = "unplugged", nth = 300',
        error=SafeStateFailed,
        after=DeviceDisconnected,
        says=("dmd", "no such device"),
        kept=0,
        again=SafeStateFailed,
        closing=SafeStateFailed,
    ),
)
