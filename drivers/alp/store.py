"""Put a sequence into the board's memory: all of it, or nothing."""

from collections.abc import Callable
from dataclasses import dataclass

from drivers.alp.board import AlpBoard
from drivers.alp.constants import FlutMode, SequenceControl, SequenceInquiry
from drivers.alp.inspection import set_binary_mode
from drivers.alp.release import release
from drivers.alp.settings import Dlp7000Settings
from drivers.alp.upload import Upload, batches
from protocols.errors import ProtocolViolation
from protocols.modulator import ModulatorTiming, PatternSequence, UploadProgress


@dataclass(frozen=True)
class Loaded:
    """A sequence in the board's memory."""

    handle: int
    """Id that the board gave the sequence."""

    pictures: int
    """Number of pictures in one run, the guard included."""

    timing: ModulatorTiming
    """Timing, as the board keeps it."""


def store(
    board: AlpBoard,
    sequence: PatternSequence,
    upload: Upload,
    timing: ModulatorTiming,
    *,
    settings: Dlp7000Settings,
    go_on: Callable[[], None],
    progress: UploadProgress | None,
) -> Loaded:
    """Reserve memory, set modes and times, upload in batches. After an error the memory is free again.

    Args:
        board: an idle board.
        sequence: the patterns.
        upload: how they lie in memory.
        timing: as asked for.
        settings: batch size and bit order.
        go_on: called before each batch and at the end; raises where the upload was halted meanwhile.
        progress: told (unique patterns stored, unique patterns in all) after each batch.
    """
    handle = board.allocate_sequence(len(upload.planes))
    try:
        set_binary_mode(board, handle)
        board.control_sequence(handle, SequenceControl.REPEAT, 1)
        if upload.mode is not FlutMode.NONE:
            board.control_sequence(handle, SequenceControl.FLUT_MODE, upload.mode)
            board.control_sequence(handle, SequenceControl.FLUT_ENTRIES9, upload.entries9)
            board.control_sequence(handle, SequenceControl.FLUT_OFFSET9, 0)
            board.write_flut(upload.mode, upload.entries)
        board.set_timing(
            handle, picture_us=timing.picture_time_us, delay_us=timing.sync_delay_us, width_us=timing.sync_width_us
        )
        kept = _kept_timing(board, handle)
        for first, planes in batches(sequence, upload, settings.upload_batch, settings.bit_order):
            go_on()
            board.put(handle, first, planes)
            if progress is not None:
                progress(upload.distinct(first + len(planes)), upload.distinct(len(upload.planes)))
        go_on()
    except BaseException as error:
        release([lambda: board.free_sequence(handle)], error)
        raise
    return Loaded(handle, len(sequence.play_order), kept)


def _kept_timing(board: AlpBoard, handle: int) -> ModulatorTiming:
    picture_us = board.inquire_sequence(handle, SequenceInquiry.PICTURE_TIME)
    delay_us = board.inquire_sequence(handle, SequenceInquiry.SYNCH_DELAY)
    width_us = board.inquire_sequence(handle, SequenceInquiry.SYNCH_PULSEWIDTH)
    if picture_us < 1 or delay_us < 0 or width_us < 1:
        raise ProtocolViolation(
            device=board.name,
            saw=f"a picture time of {picture_us} us, a sync delay of {delay_us} us and a sync width of {width_us} us",
            expected="times that can be",
            remedy="check that the library fits the board (`kinopix drivers`)",
        )
    return ModulatorTiming(picture_time_us=picture_us, sync_delay_us=delay_us, sync_width_us=width_us)
