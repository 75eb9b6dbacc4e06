"""Faults of the Zaber controller (zaber-and-grbl.md, section 6)."""

from typing import Any, Final

from protocols import (
    DeviceDisconnected,
    DeviceError,
    DeviceRefused,
    DeviceTimeout,
    DriverUnavailable,
    SafeStateFailed,
)
from tests.faults.row import ErrorType, Row


def _row(fault: str, line: str, **answers: object) -> Row:
    values: dict[str, Any] = {"fault": fault, "stage": "zaber", "emulator": f"faults = [{{ {line} }}]", **answers}
    return Row(**values)


def _unsafe(fault: str, line: str, after: ErrorType, *says: str, kept: int | None = 0) -> Row:
    """A stage that does not tell that it stands."""
    return _row(
        fault,
        line,
        error=SafeStateFailed,
        after=after,
        says=("stage", *says, "switch off by hand"),
        kept=kept,
        again=SafeStateFailed,
        closing=SafeStateFailed,
    )


_QUESTION: Final = 'at = "get pos"'

ROWS: Final = (
    _row("mute from the start", 'kind = "mute"', at_opening=True, error=DriverUnavailable, says=("stage",), kept=0),
    _row("no port", 'kind = "port-vanishes"', at_opening=True, error=DeviceDisconnected, says=("stage",), kept=0),
    _row("a reply to a question is lost: it is asked once more", f'kind = "lost-reply", {_QUESTION}', again="good"),
    _row(
        "a byte of a position is corrupted: the checksum tells", f'kind = "corrupted-byte", {_QUESTION}', again="good"
    ),
    _row("the reply before comes once more", 'kind = "old-reply", nth = 6', again="good"),
    _row("alerts and infos between every command and its reply", 'kind = "chatter"', again="good"),
    _row(
        "the reply to the move is lost: it may have begun, so it is stopped",
        'kind = "lost-reply", at = "move", nth = 2',
        error=DeviceTimeout,
        says=("stage", "not a byte", "move abs 278125"),
        kept=0,
        again="good",
    ),
    _row(
        "the move is rejected",
        'kind = "rejected", at = "move", nth = 2',
        error=DeviceRefused,
        says=("stage", "BADDATA", "travel_mm"),
        kept=0,
        again="good",
    ),
    _row(
        "the stage stalls in the run-up, and sees it",
        'kind = "stall", after = 0.2',
        error=DeviceError,
        says=("stage", "over at 3.56 mm", "FS, stalled and stopped"),
        counts="wrong",
        again=None,  # it begins where the first one stalled
    ),
    _row(
        "the motor has no current",
        "",
        emulator="driver_enabled = false",
        error=DeviceRefused,
        says=("stage", "DRIVERDISABLED", "FO, driver disabled", "driver enable"),
        kept=0,
    ),
    _unsafe("mute from a setting on", 'kind = "mute", at = "set"', DeviceTimeout, "no position"),
    _unsafe("mute while it moves", 'kind = "mute", at = "move", nth = 2, behind = true', DeviceTimeout, kept=None),
    _unsafe("the port vanishes at a setting", 'kind = "port-vanishes", at = "set"', DeviceDisconnected),
    _unsafe("the port vanishes at the move", 'kind = "port-vanishes", at = "move", nth = 2', DeviceDisconnected),
    _unsafe(
        "the port vanishes while it moves",
        'kind = "port-vanishes", at = "move", nth = 2, behind = true',
        DeviceDisconnected,
        kept=None,
    ),
)
