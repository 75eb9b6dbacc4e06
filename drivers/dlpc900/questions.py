"""What a bench with this board has to answer."""

from typing import Final

from drivers.dlpc900.constants import (
    DISPLAY_MODE,
    HARDWARE,
    HARDWARE_STATUS,
    LAST_ERROR,
    MAIN_STATUS,
    SYSTEM_STATUS,
    VERSION,
)
from drivers.dlpc900.driver import open_link
from drivers.dlpc900.settings import Dlpc900Settings
from protocols import Answer, BenchContext, BenchQuestion, FigureValue, KinopixError

_ASKED: Final = {
    "hardware": HARDWARE,
    "version": VERSION,
    "hardware_status": HARDWARE_STATUS,
    "system_status": SYSTEM_STATUS,
    "main_status": MAIN_STATUS,
    "display_mode": DISPLAY_MODE,
    "last_error": LAST_ERROR,
}


def state(settings: Dlpc900Settings, context: BenchContext) -> Answer:
    """The bytes of the board's own state, as it is found; nothing is changed."""
    link = open_link(settings, context)
    told: dict[str, FigureValue] = {}
    try:
        for name, command in _ASKED.items():
            try:
                told[name] = link.read(command).hex(" ")
            except KinopixError as error:
                told[name] = f"{type(error).__name__}: {error.saw}"
    finally:
        link.close()
    return Answer(said=f"display mode {told['display_mode']}, main status {told['main_status']}", figures=told)


QUESTIONS: Final[tuple[BenchQuestion[Dlpc900Settings], ...]] = (
    BenchQuestion("Which mirrors, which firmware?", measured="identity"),
    BenchQuestion(
        "Order of the colour bytes.",
        measured="order",
        by_hand="show planes with a single lit column, 0 to 23 in turn: the line must move by one column each time",
    ),
    BenchQuestion("Display mode and main status after power-up.", ask=state, by_hand="run this first after power-up"),
    BenchQuestion(
        "Does a change without stop give error 5, or lock the board up?",
        by_hand="not tried by the program, which always stops first",
    ),
    BenchQuestion(
        "Voltage and drive of TRIG_OUT2; does its pulse come at the start of the exposure?",
        measured="pulses",
        by_hand="oscilloscope on TRIG_OUT2, and a photodiode beside it",
    ),
    BenchQuestion(
        'Does "repeat once" stop by itself, and is the running bit then 0? What do the mirrors show afterwards?',
        measured="playing",
        by_hand="look at the mirrors afterwards",
    ),
    BenchQuestion("Bytes a second of the upload, for random patterns.", measured="upload"),
    BenchQuestion("Do 400 entries fit, or 512 as the field says?", measured="playing"),
)
"""In the order of the how-to."""
