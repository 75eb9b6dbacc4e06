"""What a debounce code means, by either source (h10682-daq.md 5.2): they disagree by one step."""

from typing import Literal

_STEPS_S = (
    500e-9, 1500e-9, 3500e-9, 7500e-9, 15500e-9, 31500e-9, 63500e-9, 127500e-9,
    100e-6, 300e-6, 700e-6, 1500e-6, 3100e-6, 6300e-6, 12700e-6, 25500e-6,
)  # fmt: skip

CODES = len(_STEPS_S) + 1


def debounce_s(code: int, table: Literal["uldaq", "wjasper"]) -> float:
    """Time for which an input must be stable; 0: the debounce is off. Bit 5 and above say other things."""
    steps = (*_STEPS_S, 0.0) if table == "uldaq" else (0.0, *_STEPS_S)
    code &= 0x1F
    return steps[code] if code < CODES else steps[-1]
