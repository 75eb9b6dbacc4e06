"""What the controller's two letters and its reasons mean (fact sheet, sections 2.2 and 2.3)."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

NOT_HOMED: Final = frozenset({"WR", "WH"})
"""Flags of an axis that does not know its origin."""

MEANING: Final[Mapping[str, str]] = MappingProxyType(
    {
        "FF": "critical system error",
        "FN": "peripheral not supported",
        "FZ": "peripheral inactive",
        "FH": "emergency stop of the hardware",
        "FV": "voltage too high or too low",
        "FO": "driver disabled",
        "FC": "inrush current",
        "FM": "motor too hot",
        "FD": "driver disabled",
        "FQ": "encoder error",
        "FI": "index error",
        "FA": "analog encoder not in step",
        "FR": "overdrive",
        "FS": "stalled and stopped",
        "FB": "stream out of bounds",
        "FP": "off its path",
        "FE": "limit error",
        "FT": "excessive twist",
        "WL": "unexpected limit",
        "WV": "voltage",
        "WT": "temperature",
        "WS": "stalled, and recovered",
        "WM": "pushed away while it stood",
        "WP": "bad calibration",
        "WR": "no reference position",
        "WH": "not homed",
        "NC": "moved by hand",
        "NI": "movement interrupted",
        "ND": "discontinuity",
        "NR": "value rounded",
        "NT": "value truncated",
        "NU": "setting not yet in force",
        "NJ": "joystick being calibrated",
        "NB": "firmware being updated",
    }
)

REMEDY: Final[Mapping[str, str]] = MappingProxyType(
    {
        "BADAXIS": "set axis in bench.toml to one that the controller has",
        "BADCOMMAND": "see whether this firmware knows the command; the driver was written for the ASCII protocol",
        "BADDATA": "see that travel_mm and the velocities of bench.toml lie within the controller's own limits",
        "DRIVERDISABLED": "send `driver enable`, by the maker's console, when it is safe",
        "PARKED": "send `tools parking unpark`, by the maker's console",
        "REMOTE": "take the controller out of its remote mode, by the maker's console",
        "STATUSBUSY": "wait until the stage stands",
        "NOACCESS": "let the maker's console lower the access level that the setting needs",
    }
)


def in_words(flag: str) -> str:
    """Give a flag and its meaning; empty for none.

    >>> in_words("FS")
    'FS, stalled and stopped'
    """
    return f"{flag}, {MEANING.get(flag, 'which the fact sheet does not know')}" if flag else ""
