"""The entry point: how ``kinopix`` finds, checks and opens the DLP7000."""

from drivers.alp.binding import bind
from drivers.alp.board import AlpBoard
from drivers.alp.constants import DeviceInquiry
from drivers.alp.driver import Dlp7000
from drivers.alp.library import find_library
from drivers.alp.questions import QUESTIONS
from drivers.alp.release import release
from drivers.alp.settings import Dlp7000Settings
from protocols.errors import DeviceBusy, DriverUnavailable
from protocols.plugin import Availability, BenchContext, DriverPlugin


def open_dlp7000(settings: Dlp7000Settings, context: BenchContext) -> Dlp7000:
    """Open the board through the vendor's library, or through ``context.transport``: an ``AlpApi`` (see ``api``).

    Raises:
        KinopixError: as ``Dlp7000``; ``DriverUnavailable`` where there is no library.
    """
    if context.transport is not None:
        name = type(context.transport).__name__
        return Dlp7000(bind(context.transport), settings, context.clock, library=f"transport {name}", simulated=True)
    setting = None if settings.library is None else context.folder / settings.library
    found = find_library(setting)
    return Dlp7000(found.api, settings, context.clock, library=found.label)


def availability() -> Availability:
    """Look for the library and load it; no board is touched."""
    try:
        return Availability(ready=True, version=find_library(None).label)
    except DriverUnavailable as error:
        return Availability(ready=False, missing=str(error))


def probe() -> tuple[str, ...]:
    """Take the first board, read its number and mirror type, and let go of it. Nothing is shown."""
    try:
        found = find_library(None)
        board = AlpBoard(found.api, 0, "dmd")
    except DeviceBusy:
        return ("ALP board, held by another program, or by one that was killed",)
    except DriverUnavailable:
        return ()
    try:
        serial, dmd = board.inquire(DeviceInquiry.DEVICE_NUMBER), board.inquire(DeviceInquiry.DMD_TYPE)
    except BaseException as error:
        release([board.halt, board.free], error)
        raise
    release([board.halt, board.free])
    return (f"ALP board {serial}, DMD type {dmd}, through {found.label}",)


plugin = DriverPlugin(
    summary="DLP7000 on a ViALUX V-7000 board, through the ALP-4 library",
    settings=Dlp7000Settings,
    open=open_dlp7000,
    availability=availability,
    probe=probe,
    questions=QUESTIONS,
)
