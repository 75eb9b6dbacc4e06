"""GRBL's numbers in words (fact sheet, sections 3.4 and 3.5)."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

ERRORS: Final[Mapping[int, tuple[str, str]]] = MappingProxyType(
    {
        1: ("a letter was expected", "report this: the driver and this firmware do not agree"),
        2: ("a bad number", "report this: the driver and this firmware do not agree"),
        3: ("an unknown command", "see that the firmware is GRBL 1.1"),
        5: ("homing is not enabled", "fit limit switches and set $22=1, or do not home"),
        8: (
            "it is not idle: it moves, or is locked by an alarm",
            "home the stage, or set unlock = true where it has no switches",
        ),
        9: ("it is locked by an alarm", "home the stage, or set unlock = true where it has no switches"),
        10: ("soft limits need homing", "set $22=1, or $20=0"),
        12: ("more than 30,000 steps a second", "lower $110, or the steps a millimetre"),
        15: ("a target beyond its soft limits", "correct travel_mm in bench.toml, or $130 of the controller"),
        16: ("a jog with words that it does not take", "see that the firmware is GRBL 1.1"),
        20: ("a G-code that it does not support", "see that the firmware is GRBL 1.1"),
        22: ("no feed rate", "report this: the driver and this firmware do not agree"),
        33: ("an invalid target", "correct travel_mm in bench.toml"),
    }
)
"""Meaning and remedy of the errors that a stage can meet."""

ALARMS: Final[Mapping[int, str]] = MappingProxyType(
    {
        1: "a limit switch was hit; the position is lost",
        2: "a soft limit was to be passed",
        3: "reset while it moved; the position is lost",
        6: "reset during homing; the position is lost",
        7: "the door was opened during homing",
        8: "homing: the switch did not open again",
        9: "homing: no switch was found",
        10: "homing: the second switch was not found",
    }
)

SILENT: Final = frozenset({1, 2})
"""Alarms after which the controller says nothing until it is reset."""

LOST: Final = frozenset({1, 3, 6, 7, 8, 9, 10})
"""Alarms after which it does not know where it is."""


def alarm_in_words(code: int) -> str:
    """Give an alarm and its meaning.

    >>> alarm_in_words(9)
    'ALARM:9, homing: no switch was found'
    """
    return f"ALARM:{code}, {ALARMS.get(code, 'which the fact sheet does not know')}"
