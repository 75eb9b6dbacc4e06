"""Faults of the GRBL board (zaber-and-grbl.md, section 6). The second jog is the run's motion."""

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
    values: dict[str, Any] = {"fault": fault, "stage": "grbl", "emulator": f"faults = [{{ {line} }}]", **answers}
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


ROWS: Final = (
    _row("mute from the start", 'kind = "mute"', at_opening=True, error=DriverUnavailable, says=("stage",), kept=0),
    _row("no port", 'kind = "port-vanishes"', at_opening=True, error=DeviceDisconnected, says=("stage",), kept=0),
    _row("a status line is lost: it is asked for once more", 'kind = "lost-reply", at = "?", nth = 5', again="good"),
    _row(
        "a byte of a status line is corrupted: it is asked for once more",
        'kind = "corrupted-byte", at = "?", nth = 5',
        again="good",
    ),
    _row(
        "a digit of a position is corrupted while it moves: nothing tells, and nothing is lost",
        'kind = "corrupted-byte", at = "?", nth = 6, byte = 11',
        again="good",
    ),
    _row(
        "the ok of the move is lost: it may have begun, so it is stopped",
        'kind = "lost-reply", at = "$J", nth = 2',
        error=DeviceTimeout,
        says=("stage", "not a byte", "X17.8000"),
        kept=0,
        again="good",
    ),
    _row(
        "the ok of the move comes too late",
        'kind = "late-reply", at = "$J", nth = 2, delay_s = 0.7',
        error=DeviceTimeout,
        says=("stage", "not a byte", "X17.8000"),
        kept=0,
        again="good",
    ),
    _row(
        "the move is refused",
        'kind = "error", at = "$J", nth = 2',
        error=DeviceRefused,
        says=("stage", "error:15", "soft limits", "travel_mm"),
        kept=0,
        again="good",
    ),
    _row(
        "the board starts anew behind the last pattern, while the stage still moves, and is locked",
        'kind = "reset", at = "$J", nth = 2, behind = true',
        error=DeviceError,
        says=("stage", "ALARM:3, reset while it moved"),
        again=DeviceRefused,
    ),
    _row(
        "the motor loses its steps in the run-up: the controller counts on, and no answer tells",
        'kind = "stall", after = 0.2',
        counts="wrong",
        again=None,
    ),
    _row(
        "a limit switch in the run-up",
        "",
        emulator="travel_mm = [0.0, 5.0]",
        error=DeviceError,
        says=("stage", "over at 5 mm", "ALARM:1, a limit switch was hit"),
        counts="wrong",
        again=DeviceRefused,
    ),
    _unsafe("mute from a setting on", 'kind = "mute", at = "$120"', DeviceTimeout, "no position"),
    _unsafe("mute while it moves", 'kind = "mute", at = "$J", nth = 2, behind = true', DeviceTimeout, kept=None),
    _unsafe("the port vanishes at a setting", 'kind = "port-vanishes", at = "$120"', DeviceDisconnected),
    _unsafe("the port vanishes at the move", 'kind = "port-vanishes", at = "$J", nth = 2', DeviceDisconnected),
    _unsafe(
        "the port vanishes while it moves",
        'kind = "port-vanishes", at = "$J", nth = 2, behind = true',
        DeviceDisconnected,
        kept=None,
    ),
)
