"""Pictures in characters: a series as a line of blocks, an image as half blocks or shades."""

from itertools import groupby
from typing import Final

import numpy as np
from rich.style import Style
from rich.text import Text

from protocols import Floats

_BARS: Final = "▁▂▃▄▅▆▇█"
_SHADES: Final = " ░▒▓█"
_GREYS: Final = 32  # few enough that neighbours are often equal and are drawn at once
_LIT: Final = 0.3  # of the brightest pixel, from which on a pixel is the object's
_MOST: Final = (0.01, 0.99)
_BELOW_WHITE: Final = 0.998
_STEP_PX: Final = 8  # by which the part that is shown moves, so that it does not tremble


def sparkline(series: Floats, width: int) -> str:
    """Draw a series as one line of blocks, lowest to highest value, with both figures behind it."""
    index = np.linspace(0, len(series) - 1, max(1, min(width, len(series)))).round().astype(np.int64)
    low, high = float(series.min()), float(series.max())
    span = max(high - low, 1e-9)
    level = np.minimum(((series[index] - low) / span * len(_BARS)).astype(np.int64), len(_BARS) - 1)
    return "".join(_BARS[k] for k in level.tolist()) + f" {low:+.1f} to {high:+.1f} px"


def half_blocks(image: Floats, side: int, *, colour: bool = True) -> Text:
    """Draw a square image, 0 to its brightest pixel, on ``side`` columns and half as many lines.

    Args:
        image: ``(m, m)``.
        side: even, at most m; the image is averaged down to it.
        colour: two greys a character; without, five shades of one.
    """
    small = _smaller(image, side)
    small = np.clip(small / max(white_of(small), 1e-30), 0, 1)
    text = Text(no_wrap=True)
    if not colour:
        shade = ((small[0::2] + small[1::2]) / 2 * (len(_SHADES) - 1)).round().astype(np.int64)
        return text.append("\n".join("".join(_SHADES[k] for k in line) for line in shade.tolist()))
    grey: list[list[int]] = ((small * (_GREYS - 1)).round() * 255 / (_GREYS - 1)).astype(np.int64).tolist()
    for upper, lower in zip(grey[0::2], grey[1::2], strict=True):
        for (above, below), run in groupby(zip(upper, lower, strict=True)):
            style = Style(color=f"rgb({above},{above},{above})", bgcolor=f"rgb({below},{below},{below})")
            text.append("▀" * len(list(run)), style)
        text.append("\n")
    return text


def _smaller(image: Floats, side: int) -> Floats:
    """Average an image down to ``side`` rows and columns of whole pixels."""
    edge = np.arange(side) * len(image) // side
    count = np.diff(edge, append=len(image))
    summed = np.add.reduceat(np.add.reduceat(image, edge, axis=0), edge, axis=1)
    averaged: Floats = summed / np.outer(count, count)
    return averaged


def white_of(image: Floats) -> float:
    """Give what is shown as white: what all but 2 of 1000 pixels stay below, and a quarter of the brightest at least."""
    place = round(_BELOW_WHITE * (image.size - 1))
    return max(float(np.partition(image, place, axis=None)[place]), float(image.max()) / 4, 0.0)


def lit_part(image: Floats, side: int) -> tuple[int, int, int]:
    """Choose what to show of an image that is larger than its room: the part with the object, where that makes it larger.

    Args:
        image: ``(m, m)``.
        side: pixels that can be shown along each axis.

    Returns:
        First row and first column, and pixels a side, of the part.
    """
    size = len(image)
    bright = image > _LIT * white_of(image)
    if size <= side or not bright.any():
        return 0, 0, size
    # All but a few of the bright pixels: single wild ones do not make the part larger.
    ends = np.quantile(np.nonzero(bright), _MOST, axis=1, method="nearest").T
    wide = int(np.ptp(ends, axis=1).max()) + 1 + 2 * _STEP_PX
    part = max(side, -(-wide // _STEP_PX) * _STEP_PX)
    if part >= size:
        return 0, 0, size
    top, left = (
        int(np.clip(round(((int(first) + int(last) + 1) / 2 - part / 2) / _STEP_PX) * _STEP_PX, 0, size - part))
        for first, last in ends
    )
    return top, left, part
