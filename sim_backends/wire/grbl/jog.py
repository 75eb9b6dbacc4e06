"""The words of a jog (sheet, section 3.1)."""

import re
from dataclasses import dataclass

_WORD = re.compile(r"([A-Z])([^A-Z]*)")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)")
_INCH_MM = 25.4


@dataclass(frozen=True)
class Jog:
    """A jog that can be made of its words."""

    to_mm: dict[str, float]
    """By axis: target, or distance, in millimetres."""

    relative: bool
    machine: bool
    """Whether targets are machine coordinates (G53)."""

    feed_mm_s: float


def parse_jog(text: str) -> Jog | int:
    """Give the jog of what stands behind ``$J=``, or the number of an error.

    >>> parse_jog("G91G21X10.0F1500").feed_mm_s
    25.0
    >>> parse_jog("X10")
    22
    """
    if not text or not text[0].isalpha():
        return 1
    axes: dict[str, float] = {}
    feed: float | None = None
    codes: set[float] = set()
    for letter, digits in _WORD.findall(text):
        if not _NUMBER.fullmatch(digits):
            return 2
        value = float(digits)
        if letter in "XYZ":
            if letter in axes:
                return 25
            axes[letter] = value
        elif letter == "F":
            feed = value
        elif letter == "G" and value in {20, 21, 53, 90, 91}:
            codes.add(value)
        else:
            return 16
    if {20, 21} <= codes or {90, 91} <= codes:
        return 21
    if not axes:
        return 26
    if feed is None or feed <= 0:
        return 22
    scale = _INCH_MM if 20 in codes else 1.0
    to_mm = {axis: value * scale for axis, value in axes.items()}
    return Jog(to_mm, 91 in codes, 53 in codes, feed * scale / 60)
