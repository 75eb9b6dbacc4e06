"""Faults of the Zolix controllers and of the motor (ka400z.md 3F)."""

from collections.abc import Iterator
from typing import Final, Literal, TypeAlias

from protocols import (
    DeviceDisconnected,
    DeviceError,
    DeviceRefused,
    DeviceTimeout,
    DriverUnavailable,
    SafeStateFailed,
)
from tests.faults.row import ErrorType, Row

Dialect: TypeAlias = Literal["mc600", "sc300"]

_NEVER_ENDS: Final = ("stage", "17.800 of 17.800 mm done", "the line that ends the motion to 17.8 mm")

_MC600_MOVE: Final = 'at = "GoPosition"'

_SC300_MOVE: Final = 'at = "+X"'


def _behind(command: str) -> str:
    return f"{command}, behind = true"


def _fault(line: str) -> str:
    return f"faults = [{{ {line} }}]"


def _mute(dialect: Dialect, fault: str, when: str, *says: str, kept: int | None = 0) -> Row:
    """A stage that does not tell whether it obeyed the stop: that it may still move is what is raised."""
    return Row(
        fault=fault,
        stage=dialect,
        emulator=_fault(f'kind = "mute", {when}'),
        error=SafeStateFailed,
        after=DeviceTimeout,
        says=("stage", *says, "switch off by hand", "by what it was commanded, the stage"),
        kept=kept,
        again=SafeStateFailed,
        closing=SafeStateFailed,
    )


def _gone(dialect: Dialect, fault: str, when: str, kept: int | None = 0) -> Row:
    """A stage that cannot be reached may still move: that it cannot be made safe is what is raised."""
    return Row(
        fault=fault,
        stage=dialect,
        emulator=_fault(f'kind = "port-vanishes", {when}'),
        error=SafeStateFailed,
        after=DeviceDisconnected,
        says=("stage", "a serial port that fails", "switch off by hand"),
        kept=kept,
        again=SafeStateFailed,
        closing=SafeStateFailed,
    )


def _at_opening(dialect: Dialect, fault: str, line: str, error: ErrorType, *says: str) -> Row:
    return Row(
        fault=fault,
        stage=dialect,
        emulator=_fault(line),
        at_opening=True,
        error=error,
        says=("stage", *says),
        kept=0,
    )


def _common(dialect: Dialect, *, completion_byte: int) -> Iterator[Row]:
    yield _at_opening(dialect, "mute from the start", 'kind = "mute"', DriverUnavailable, "b''", "cable")
    yield _at_opening(dialect, "no port", 'kind = "port-vanishes"', DeviceDisconnected, "a serial port that fails")
    yield Row(
        fault="the line that ends the motion is lost",
        stage=dialect,
        emulator=_fault('kind = "lost-reply", at = "completion"'),
        error=DeviceTimeout,
        says=_NEVER_ENDS,
        again="good",
    )
    yield Row(
        fault="a byte of the line that ends the motion is corrupted",
        stage=dialect,
        emulator=_fault(f'kind = "corrupted-byte", at = "completion", byte = {completion_byte}'),
        error=DeviceTimeout,
        says=_NEVER_ENDS,
        again="good",
    )
    yield Row(
        fault="the line that ends the motion comes half a second late",
        stage=dialect,
        emulator=_fault('kind = "late-completion"'),
        again="good",
    )
    yield Row(
        fault="the line that ends the motion comes late, after the next run has begun to ask",
        stage=dialect,
        emulator=_fault('kind = "late-completion", delay_s = 5.0'),
        error=DeviceTimeout,
        says=_NEVER_ENDS,
        again="good",
    )
    yield Row(
        fault="the line that ends the motion comes twice",
        stage=dialect,
        emulator=_fault('kind = "duplicated-completion"'),
        again="good",
    )
    yield Row(
        fault="the motor loses its steps in the run-up: the controller counts on, and no answer tells",
        stage=dialect,
        emulator=_fault('kind = "stall", after = 0.2'),
        counts="wrong",
        again=DeviceError,
    )
    yield Row(
        fault="a limit switch in the run-up",
        stage=dialect,
        emulator="travel_mm = [0.0, 5.0]",
        error=DeviceError,
        says=("stage", "over at 5 mm", "limit switches"),
        counts="wrong",
    )
    yield Row(
        fault="a limit switch after the last pattern",
        stage=dialect,
        emulator="travel_mm = [0.0, 10.0]",
        error=DeviceError,
        says=("stage", "over at 10 mm", "limit switches"),
    )
    yield Row(
        fault="a limit switch that is never released",
        stage=dialect,
        emulator=_fault('kind = "limit-sticks"'),
        error=DeviceRefused,
        says=("stage", "limit switch"),
        kept=0 if dialect == "mc600" else None,
        counts="wrong",
    )


def mc600_rows() -> tuple[Row, ...]:
    """Of the MC600. A run asks for the position three times before it moves: to go to its start, for its log, to move."""
    dialect: Final = "mc600"
    return (
        *_common(dialect, completion_byte=3),
        _at_opening(
            dialect,
            "the answer to the fourth command is lost",
            'kind = "lost-reply", nth = 4',
            DeviceTimeout,
            "SetUnit",
        ),
        Row(
            fault="the answer to the position query of a move is lost",
            stage=dialect,
            emulator=_fault('kind = "lost-reply", at = "Position?", nth = 6'),
            error=DeviceTimeout,
            says=("stage", "not a byte", "Position? X"),
            kept=0,
            again="good",
        ),
        Row(
            fault="the answer to the position query of the run's log is lost: the stage is asked no more while the run goes on",
            stage=dialect,
            emulator=_fault('kind = "lost-reply", at = "Position?", nth = 5'),
            again="good",
        ),
        Row(
            fault="the answer to the move is lost: it may have begun, so it is stopped",
            stage=dialect,
            emulator=_fault('kind = "lost-reply", at = "GoPosition"'),
            error=DeviceTimeout,
            says=("stage", "Ready in answer to", "GoPosition"),
            kept=0,
            again="good",
        ),
        Row(
            fault="a byte of a position is corrupted",
            stage=dialect,
            emulator=_fault('kind = "corrupted-byte", at = "Position?", nth = 4, byte = 2'),
            error=DeviceTimeout,
            says=("stage", "POCITION?"),
            kept=0,
            again="good",
        ),
        _mute(dialect, "mute from a setting on", 'at = "SetInitSpeed"', "no position (not a byte"),
        _mute(dialect, "mute from the move on", _MC600_MOVE, "no position but a predicted one"),
        _mute(dialect, "mute while it moves", _behind(_MC600_MOVE), "no position but a predicted one", kept=None),
        _gone(dialect, "the port vanishes at a setting", 'at = "SetInitSpeed"'),
        _gone(dialect, "the port vanishes at the move", _MC600_MOVE),
        _gone(dialect, "the port vanishes while it moves", _behind(_MC600_MOVE), kept=None),
    )


def sc300_rows() -> tuple[Row, ...]:
    """Of the SC300, which is asked as the MC600 is."""
    dialect: Final = "sc300"
    return (
        *_common(dialect, completion_byte=3),
        _at_opening(
            dialect, "the answer to the fourth command is lost", 'kind = "lost-reply", nth = 4', DeviceTimeout, "?X"
        ),
        Row(
            fault="the answer to a setting is lost",
            stage=dialect,
            emulator=_fault('kind = "lost-reply", at = "VX"'),
            error=DeviceTimeout,
            says=("stage", "not a byte", "VX,10000"),
            kept=0,
            again="good",
        ),
        Row(
            fault="a byte of the answer to a setting is corrupted",
            stage=dialect,
            emulator=_fault('kind = "corrupted-byte", at = "AX", byte = 2'),
            error=DeviceTimeout,
            says=("stage", "O["),
            kept=0,
            again="good",
        ),
        Row(
            fault="the first byte of the line that ends the motion is corrupted, which may be a letter anyway",
            stage=dialect,
            emulator=_fault('kind = "corrupted-byte", at = "completion"'),
            again="good",
        ),
        _mute(dialect, "mute from a setting on", 'at = "FX"', "no position (not a byte"),
        _mute(dialect, "mute while it moves", _SC300_MOVE, "no position but a predicted one", kept=None),
        _gone(dialect, "the port vanishes at a setting", 'at = "FX"'),
        _gone(dialect, "the port vanishes at the move", _SC300_MOVE),
        _gone(dialect, "the port vanishes while it moves", _behind(_SC300_MOVE), kept=None),
    )
