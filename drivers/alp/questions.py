"""What a bench with this board has to answer."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import partial
from typing import Final

from drivers.alp.binding import bind
from drivers.alp.board import AlpBoard
from drivers.alp.constants import DeviceInquiry, ProjectionInquiry
from drivers.alp.inspection import inspect, set_binary_mode
from drivers.alp.library import find_library
from drivers.alp.release import release
from drivers.alp.settings import Dlp7000Settings
from protocols import Answer, BenchContext, BenchQuestion, DeviceRefused, FigureValue, KinopixError

_NAME: Final = "dmd"


@contextmanager
def _board(settings: Dlp7000Settings, context: BenchContext) -> Generator[tuple[AlpBoard, str]]:
    """A board that nobody else holds, and the name of its library; given back on every way out."""
    if context.transport is not None:
        api, label = bind(context.transport), f"transport {type(context.transport).__name__}"
    else:
        found = find_library(None if settings.library is None else context.folder / settings.library)
        api, label = found.api, found.label
    board = AlpBoard(api, settings.device_number, _NAME, context.clock)
    try:
        yield board, label
    except BaseException as error:
        release([board.halt, board.free], error)
        raise
    release([board.halt, board.free])


def board_facts(settings: Dlp7000Settings, context: BenchContext) -> Answer:
    """Everything that the board tells of itself."""
    with _board(settings, context) as (board, label):
        figures: dict[str, FigureValue] = {
            inquiry.name.lower(): _told(partial(board.inquire, inquiry)) for inquiry in DeviceInquiry
        }
        figures["flut_max_entries9"] = _told(lambda: board.inquire_projection(ProjectionInquiry.FLUT_MAX_ENTRIES9))
        limits = inspect(board, settings).limits
    figures |= {
        "library": label,
        "min_picture_time_us": limits.shortest_picture_time_us,
        "max_picture_time_us": limits.longest_picture_time_us,
    }
    return Answer(
        said=f"board {figures['device_number']}, DMD type {figures['dmd_type']}, ALP_VERSION {figures['version']}, {label}",
        figures=figures,
    )


def impossible_times(settings: Dlp7000Settings, context: BenchContext) -> Answer:
    """Codes of ``AlpSeqTiming`` for a picture time of 1 us, and for a sync pulse longer than its picture. Nothing is shown."""
    codes: dict[str, FigureValue] = {}
    with _board(settings, context) as (board, _):
        sequence = board.allocate_sequence(1)
        try:
            set_binary_mode(board, sequence)
            for name, picture_us, width_us in (("picture_1_us", 1, 1), ("sync_longer_than_picture", 100, 200)):
                codes[name] = _refusal(board, sequence, picture_us, width_us)
        finally:
            board.free_sequence(sequence)
    return Answer(said=", ".join(f"{name}: {code}" for name, code in codes.items()), figures=codes)


def _refusal(board: AlpBoard, sequence: int, picture_us: int, width_us: int) -> str:
    try:
        board.set_timing(sequence, picture_us=picture_us, delay_us=0, width_us=width_us)
    except DeviceRefused as refused:
        return str(refused.code)
    except KinopixError as error:
        return f"{type(error).__name__}: {error.saw}"
    return "taken"


def _told(ask: Callable[[], int]) -> int | str:
    try:
        return ask()
    except DeviceRefused as refused:
        return f"refused ({refused.code})"


QUESTIONS: Final[tuple[BenchQuestion[Dlp7000Settings], ...]] = (
    BenchQuestion(
        "Which board, which ALP release, which library file? What do version, type, memory, shortest picture time and "
        "table length read?",
        ask=board_facts,
    ),
    BenchQuestion(
        "Does `ALP_VERSION` hold the release in its high byte? One laboratory saw 0x0401 for 4.1. If not: "
        "`accept_any_version = true`.",
        measured="identity",
        by_hand="hold ALP_VERSION, under identity, against the release on the maker's medium",
    ),
    BenchQuestion(
        "Voltage, drive, connector and polarity of the sync output.",
        by_hand="oscilloscope on the sync output, at 50 ohm",
    ),
    BenchQuestion("Do N pictures give exactly N pulses, ten thousand a second and more?", measured="pulses"),
    BenchQuestion("Does the first pulse come with picture 0?", measured="order"),
    BenchQuestion(
        'Does the projection state read "active" at once after the start? The driver waits up to 20 ms before it asks.',
        measured="playing",
    ),
    BenchQuestion(
        "What do the mirrors show after a halt, and do they wake from their parked state quickly enough for the first picture?",
        measured="order",
        by_hand="look at the array after a halt: dark?",
    ),
    BenchQuestion(
        "Is the display idle only when the last picture's time is over, or as soon as it is shown? The driver allows either.",
        measured="playing",
    ),
    BenchQuestion("Which codes do impossible times really give? The driver expects any.", ask=impossible_times),
    BenchQuestion("How long do patterns take to be stored?", measured="upload"),
)
"""In the order of the how-to."""
