"""Pictures by name, for looking at a bench and for measuring it.

``white``, ``black``, ``half`` (the left one), ``checker``, ``fringe``, ``crosshair`` and ``letter`` need no numbers. A name may
carry numbers after a colon, in image pixels: ``checker:2`` has cells of 2 px, ``fringe:4`` four periods across the field,
``columns:8-24`` lights columns 8 to 23, ``rows:0-64`` rows 0 to 63, and ``block:0,16,8,4`` begins at row 0 and column 16, and
is 8 high and 4 wide. ``not`` before a name gives the complement.
"""

import re
from collections.abc import Callable
from typing import Final

import numpy as np

from instrument.patterns.fourier import fourier_pattern
from protocols import Bytes, InputError

PICTURES: Final = ("white", "black", "half", "checker", "fringe", "crosshair", "letter")
"""Names that need no numbers."""

_FORM: Final = re.compile(r"(?P<negated>not )?(?P<name>[a-z]+)(?::(?P<numbers>\d{1,5}(?:[-,]\d{1,5})*))?")

_LETTER: Final = ((0.0, 0.0, 0.2, 1.0), (0.0, 0.0, 0.7, 0.2), (0.0, 0.4, 0.5, 0.6))
"""Left, top, right and bottom of the strokes of the letter F, in its own height."""

LETTER_WIDTH: Final = 0.7
"""Width of the letter over its height."""


def picture(name: str, size: int) -> Bytes:
    """Give a picture by its name.

    Args:
        name: as the head of this module says.
        size: image pixels a side.

    Returns:
        ``(size, size)`` of 0 and 1, row = y (down).

    Raises:
        InputError: there is no such picture, or it does not fit the field.
    """
    form = _FORM.fullmatch(name)
    draw = None if form is None else _DRAWN.get(form["name"])
    if form is None or draw is None:
        raise _no_such(name)
    numbers = [int(part) for part in re.split("[-,]", form["numbers"])] if form["numbers"] else []
    try:
        lit = draw(size, *numbers)
    except TypeError:  # another count of numbers than the picture takes
        raise _no_such(name) from None
    except ValueError as error:
        raise InputError(
            saw=f"the picture {name!r}: {error}",
            expected=f"a part of a field of {size} x {size} px",
            remedy="correct the numbers, or the image size",
        ) from None
    return np.asarray(1 - lit if form["negated"] else lit, np.uint8)


def letter(height: int) -> Bytes:
    """Give the letter F, which looks different in each of the eight ways in which a square can lie.

    Args:
        height: in samples.

    Returns:
        ``(height, 0.7 height)`` of 0 and 1, upright.
    """
    x = (np.arange(max(1, round(LETTER_WIDTH * height))) + 0.5) / height
    y = (np.arange(height)[:, None] + 0.5) / height
    lit = np.zeros((len(y), len(x)), np.uint8)
    for left, top, right, bottom in _LETTER:
        lit |= ((left <= x) & (x < right) & (top <= y) & (y < bottom)).astype(np.uint8)
    return lit


def _white(size: int) -> Bytes:
    return np.ones((size, size), np.uint8)


def _black(size: int) -> Bytes:
    return np.zeros((size, size), np.uint8)


def _half(size: int) -> Bytes:
    return _block(size, 0, 0, size, size // 2)


def _checker(size: int, cell: int = 0) -> Bytes:
    cell = cell or max(1, size // 8)
    index = np.arange(size) // cell
    return np.asarray((index[:, None] + index + 1) % 2, np.uint8)


def _fringe(size: int, cycles: int = 2) -> Bytes:
    if not 0 < cycles <= size // 2:
        raise ValueError(f"{cycles} periods")
    return fourier_pattern(size, cycles, 0.0, "x")


def _crosshair(size: int) -> Bytes:
    lit, middle = _black(size), size // 2
    lit[middle - 1 : middle + 1] = 1
    lit[:, middle - 1 : middle + 1] = 1
    for side in (0, size - 1):  # the border of the field
        lit[side] = lit[:, side] = 1
    return lit


def _letter(size: int) -> Bytes:
    lit, drawn = _black(size), letter(max(1, size // 2))
    height, width = drawn.shape
    top, left = (size - height) // 2, (size - width) // 2
    lit[top : top + height, left : left + width] = drawn
    return lit


def _columns(size: int, first: int, end: int) -> Bytes:
    return _block(size, 0, first, size, end - first)


def _rows(size: int, first: int, end: int) -> Bytes:
    return _block(size, first, 0, end - first, size)


def _block(size: int, top: int, left: int, height: int, width: int) -> Bytes:
    if height <= 0 or width <= 0 or top + height > size or left + width > size:
        raise ValueError(f"rows {top} to {top + height}, columns {left} to {left + width}")
    lit = _black(size)
    lit[top : top + height, left : left + width] = 1
    return lit


_DRAWN: Final[dict[str, Callable[..., Bytes]]] = {
    "white": _white,
    "black": _black,
    "half": _half,
    "checker": _checker,
    "fringe": _fringe,
    "crosshair": _crosshair,
    "letter": _letter,
    "columns": _columns,
    "rows": _rows,
    "block": _block,
}


def _no_such(name: str) -> InputError:
    return InputError(
        saw=f"the picture {name!r}",
        expected=f"one of {', '.join(PICTURES)}, columns:a-b, rows:a-b or block:top,left,height,width",
        remedy="correct the name",
    )
