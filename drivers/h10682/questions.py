"""What a bench with an H10682 has to answer, on whichever board."""

from typing import Any, Final

from protocols import BenchQuestion

HEAD_QUESTIONS: Final[tuple[BenchQuestion[Any], ...]] = (
    BenchQuestion(
        "Dark rate of the -210: 600 or 50 a second? (`head.dark_rate_hz = 0`: not measured.)",
        measured="dark",
        by_hand="after half an hour of darkness, with the shutter closed: kinopix calibrate detector --shutter-closed",
    ),
    BenchQuestion(
        "Overlight line of the head on a digital input? (Not read by these drivers.)",
        by_hand="is the line wired, and to what?",
    ),
)
"""In the order of the how-to."""
