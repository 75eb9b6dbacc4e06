"""Suggestions of what a misspelt name was meant to be."""

import re
from collections.abc import Iterable
from difflib import get_close_matches

_UNITS = {
    "nm": "nm", "um": "um", "mm": "mm", "cm": "cm", "m": "m",
    "ns": "ns", "us": "us", "ms": "ms", "s": "s", "min": "min",
    "hz": "Hz", "khz": "kHz", "mhz": "MHz",
    "px": "px", "pulses": "pulses", "deg": "deg", "rad": "rad",
    "v": "V", "mv": "mV", "ma": "mA", "percent": "%",
}  # fmt: skip
_UNIT_WORD = re.compile(r"([a-z]+)(\d*)")


def unit_of(name: str) -> tuple[str, str]:
    """Split a name into what it names and its unit: ``velocity_mm_s`` gives ``velocity`` and ``mm/s``."""
    words, units = name.lower().split("_"), list[str]()
    while len(words) > 1:
        found = _UNIT_WORD.fullmatch(words[-1])
        if found is None or found[1] not in _UNITS:
            break
        units.insert(0, _UNITS[found[1]] + found[2])
        words.pop()
    if len(words) > 1 and words[-1] == "per" and units:
        units.insert(0, "1")
        words.pop()
    return "_".join(words), "/".join(units)


def suggest_key(key: str, known: Iterable[str]) -> str:
    """Say which of the ``known`` keys was meant, and its unit if the mistake is in the unit; empty if none is similar."""
    known = list(known)
    stem, unit = unit_of(key)
    same_stem = [name for name in known if unit_of(name)[0] == stem]
    near = same_stem[:1] or get_close_matches(key, known, n=1)
    if not near:
        return ""
    right_unit = unit_of(near[0])[1]
    if unit == right_unit or not right_unit:
        return f"did you mean {near[0]}?"
    if not unit:
        return f"did you mean {near[0]}, in {right_unit}?"
    return f"did you mean {near[0]}, in {right_unit}? Convert the value from {unit}"


def suggest_value(value: str, known: Iterable[str]) -> str:
    """Say which of the ``known`` values was meant; empty if none is similar."""
    near = get_close_matches(value.lower(), list(known), n=1)
    return f"did you mean {near[0]!r}?" if near else ""
