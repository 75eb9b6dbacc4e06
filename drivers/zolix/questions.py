"""What a bench with this stage has to answer. ``examples/capture_zolix.py`` writes the bytes down that some of them are about."""

from typing import Final

from drivers.zolix.settings import Ka400zSettings
from protocols import BenchQuestion

_CAPTURE: Final = "python examples/capture_zolix.py PORT mc600 (or sc300), and send capture.txt"

QUESTIONS: Final[tuple[BenchQuestion[Ka400zSettings], ...]] = (
    BenchQuestion(
        "Controller model and firmware (`VE`, `Hello`).", measured="identity", by_hand="the label on the controller"
    ),
    BenchQuestion(
        "Lead, microstep switches, motor current.",
        measured="travel",
        by_hand="the switches on the driver, and a ruler beside 2 mm of travel",
    ),
    BenchQuestion(
        "What is sent at the end of a move, byte for byte (SC300: which first byte; MC600: after homing too).",
        by_hand=_CAPTURE,
    ),
    BenchQuestion("Is a position query, and a stop, answered while moving?", measured="travel"),
    BenchQuestion(
        "The answer to `Stop X` / `SPX`. (`SPX` comes from one source only.)", measured="stop", by_hand=_CAPTURE
    ),
    BenchQuestion("What `E0`, `E1`, `ER` / `E01`, `E02` mean.", by_hand=_CAPTURE),
    BenchQuestion(
        "Homing: direction, kind of switch, position afterwards; does `SetHomeSpeed` rule it, and what on an SC300 "
        "(taken: `VX`)?",
        measured="homing",
        by_hand="direction, and kind of switch",
    ),
    BenchQuestion(
        "Is the position kept over power-off? (Taken: no.)",
        measured="standing",
        by_hand="note the position, switch off and on, and run this again",
    ),
    BenchQuestion(
        "Highest velocity without lost steps.",
        by_hand="a mark on the carriage; raise the velocity until it is not met again after ten moves there and back",
    ),
    BenchQuestion("Is a start velocity of 0 taken? Is it checked against the velocity?", measured="travel"),
)
"""In the order of the how-to."""
