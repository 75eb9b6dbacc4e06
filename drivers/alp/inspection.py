"""What the driver asks a board when it opens it, and what it refuses."""

from dataclasses import dataclass

from drivers.alp.board import AlpBoard
from drivers.alp.constants import (
    BinaryMode,
    DataFormat,
    DeviceInquiry,
    DmdType,
    ProjectionInquiry,
    SequenceControl,
    SequenceInquiry,
)
from drivers.alp.release import release
from drivers.alp.settings import Dlp7000Settings
from protocols.errors import DeviceError, DeviceRefused, DriverUnavailable, PatternMemoryFull, ProtocolViolation
from protocols.modulator import ModulatorLimits

COLUMNS, ROWS = 1024, 768
"""Columns and rows of the mirrors of a DLP7000."""


@dataclass(frozen=True)
class Inspection:
    """What a board said of itself."""

    serial: int
    """Serial number of the board."""

    version: int
    """Version of the library's device interface (ALP_VERSION)."""

    limits: ModulatorLimits
    """Geometry, picture times, and memory while nothing is loaded."""

    table_entries9: int
    """Length of the frame look-up table in 9-bit entries; 0 where the board has none, or it is switched off."""

    longest_sync_delay_us: int
    """Longest sync delay in microseconds (ALP_MAX_SYNCH_DELAY)."""


def set_binary_mode(board: AlpBoard, sequence: int) -> None:
    """Make a sequence one-bit, packed, without dark phase. Must come before its timing, which depends on it."""
    board.control_sequence(sequence, SequenceControl.DATA_FORMAT, DataFormat.BINARY_TOPDOWN)
    board.control_sequence(sequence, SequenceControl.BITNUM, 1)
    board.control_sequence(sequence, SequenceControl.BIN_MODE, BinaryMode.UNINTERRUPTED)


def inspect(board: AlpBoard, settings: Dlp7000Settings) -> Inspection:
    """Check version and mirrors, and read the limits from the board.

    Raises:
        DriverUnavailable: the board has no mirror array, or the library's version is unknown.
        DeviceError: another array than a DLP7000, or ``flut = "required"`` on a board without a look-up table.
    """
    version = board.inquire(DeviceInquiry.VERSION)
    if version >> 8 not in (4, 5) and not settings.accept_any_version:
        raise DriverUnavailable(
            device=board.name,
            saw=f"ALP version {version:#06x}",
            expected="0x04xx or 0x05xx",
            remedy="install ALP-4, or set accept_any_version = true if this is it",
        )
    _check_mirrors(board)
    memory = _positive(board, "free pictures of memory", board.inquire(DeviceInquiry.AVAIL_MEMORY))
    entries9 = _table_entries9(board, settings)
    shortest, longest, delay = _probe_times(board)
    order = {"off": memory, "required": entries9, "auto": max(memory, entries9)}[settings.flut]
    return Inspection(
        serial=board.inquire(DeviceInquiry.DEVICE_NUMBER),
        version=version,
        limits=ModulatorLimits(
            columns=COLUMNS,
            rows=ROWS,
            shortest_picture_time_us=shortest,
            longest_picture_time_us=longest,
            unique_patterns=memory,
            play_order_entries=order,
        ),
        table_entries9=entries9,
        longest_sync_delay_us=delay,
    )


def _check_mirrors(board: AlpBoard) -> None:
    dmd = board.inquire(DeviceInquiry.DMD_TYPE)
    if dmd == DmdType.DISCONNECTED:
        raise DriverUnavailable(
            device=board.name,
            saw="a board without mirror array (DMD type 255)",
            expected="DMD type 4 (DLP7000)",
            remedy="switch the board off and check the flat cable between board and DMD",
        )
    name = DmdType(dmd).name if dmd in set(DmdType) else "unknown"
    size = board.inquire(DeviceInquiry.DISPLAY_WIDTH), board.inquire(DeviceInquiry.DISPLAY_HEIGHT)
    if dmd != DmdType.DLP7000 or size != (COLUMNS, ROWS):
        raise DeviceError(
            device=board.name,
            saw=f"DMD type {dmd} ({name}) of {size[0]} x {size[1]} mirrors",
            expected=f"DMD type 4 (DLP7000) of {COLUMNS} x {ROWS} mirrors",
            remedy="choose the right board by device_number; this driver would show patterns in a wrong geometry",
        )


def _table_entries9(board: AlpBoard, settings: Dlp7000Settings) -> int:
    if settings.flut == "off":
        return 0
    try:
        entries9 = board.inquire_projection(ProjectionInquiry.FLUT_MAX_ENTRIES9)
    except DeviceRefused:
        entries9 = 0  # an older board does not know the question
    if settings.flut == "required" and entries9 < 1:
        raise DeviceError(
            device=board.name,
            saw='a board without frame look-up table, and flut = "required"',
            expected="a board that knows ALP_FLUT_MAX_ENTRIES9",
            remedy='set flut = "auto": the patterns are then stored in play order',
        )
    return max(0, entries9)


def _probe_times(board: AlpBoard) -> tuple[int, int, int]:
    """Shortest and longest picture time and longest sync delay: only a sequence can be asked for them."""
    try:
        sequence = board.allocate_sequence(1)
    except PatternMemoryFull as error:
        raise DeviceError(
            device=board.name,
            saw="no room for a single pattern (AlpSeqAlloc: 1007 ALP_MEMORY_FULL)",
            expected="free pattern memory on a board that was just opened",
            remedy="close other programs that use the board, or power-cycle it",
        ) from error
    try:
        set_binary_mode(board, sequence)
        board.set_timing(sequence, picture_us=0, delay_us=0, width_us=5)
        asked = (SequenceInquiry.MIN_PICTURE_TIME, SequenceInquiry.MAX_PICTURE_TIME, SequenceInquiry.MAX_SYNCH_DELAY)
        shortest, longest, delay = (board.inquire_sequence(sequence, inquiry) for inquiry in asked)
    except BaseException as error:
        release([lambda: board.free_sequence(sequence)], error)
        raise
    board.free_sequence(sequence)
    return (
        _positive(board, "us as shortest picture time", shortest),
        _positive(board, "us as longest picture time", longest),
        delay,
    )


def _positive(board: AlpBoard, what: str, value: int) -> int:
    if value < 1:
        raise ProtocolViolation(
            device=board.name,
            saw=f"{value} {what}",
            expected="at least 1",
            remedy="power-cycle the board, and check that the library fits it (`kinopix drivers`)",
        )
    return value
