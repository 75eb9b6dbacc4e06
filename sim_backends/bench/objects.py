"""Built-in objects, drawn by their own outlines: no fonts, the same on every machine."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from protocols.values import Floats

Ring = list[tuple[float, float]]
"""Corners (x, y) of a closed outline, in units of the object's height, y down."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """A built-in object as cells of transmission 0 to 1."""

    cells: Floats
    cell_px: float


def _inside(rings: list[Ring], x: Floats, y: Floats) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Even-odd rule: inside an odd number of outlines, so an inner ring is a hole."""
    odd = np.zeros(np.broadcast_shapes(x.shape, y.shape), np.bool_)
    for ring in rings:
        for (x0, y0), (x1, y1) in zip(ring, [*ring[1:], ring[0]], strict=True):
            if y0 != y1:
                crosses = (y0 <= y) != (y1 <= y)
                odd ^= crosses & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    return odd


def _draw(parts: list[tuple[list[Ring], float]], height_px: float) -> Drawing:
    """Paint parts (outlines, transmission) one over the other, each pixel by its own centre."""
    rows = max(1, round(height_px))
    corners = [corner for rings, _ in parts for ring in rings for corner in ring]
    columns = max(1, round(max(x for x, _ in corners) * rows))
    x, y = (np.arange(columns) + 0.5)[None, :] / rows, (np.arange(rows) + 0.5)[:, None] / rows
    cells = np.zeros((rows, columns))
    for rings, transmission in parts:
        cells[_inside(rings, x, y)] = transmission
    return Drawing(cells, 1.0)


def _box(left: float, top: float, right: float, bottom: float) -> Ring:
    return [(left, top), (right, top), (right, bottom), (left, bottom)]


def _circle(radius: float) -> Ring:
    angles = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    return [(0.5 + radius * float(np.cos(a)), 0.5 + radius * float(np.sin(a))) for a in angles]


_B_OUTLINE: Ring = [
    (0.0, 0.0), (0.60, 0.0), (0.74, 0.10), (0.74, 0.40), (0.66, 0.50),
    (0.78, 0.58), (0.78, 0.90), (0.64, 1.0), (0.0, 1.0),
]  # fmt: skip
_B: list[Ring] = [_B_OUTLINE, _box(0.25, 0.19, 0.50, 0.40), _box(0.25, 0.60, 0.53, 0.81)]
_PLANE: list[tuple[list[Ring], float]] = [
    ([[(0.66, 0.42), (1.22, 0.72), (1.22, 0.82), (0.66, 0.64)]], 0.6),
    ([[(0.56, 0.42), (0.0, 0.72), (0.0, 0.82), (0.56, 0.64)]], 0.6),
    ([[(0.61, 0.82), (0.88, 0.95), (0.88, 1.0), (0.34, 1.0), (0.34, 0.95)]], 0.4),
    (
        [[(0.57, 0.0), (0.65, 0.0), (0.68, 0.10), (0.69, 0.60), (0.64, 1.0), (0.58, 1.0), (0.53, 0.60), (0.54, 0.10)]],
        1.0,
    ),
]


def _bars() -> Drawing:
    """Three-bar groups of 4, 3, 2 and 1.5 px, upright and lying, on cells of half a pixel. They keep their size."""
    cells = np.zeros((106, 88))
    for width, top, left in ((8, 0, 0), (6, 48, 0), (4, 86, 0), (3, 86, 48)):
        side, gap = 5 * width, width
        for bar in range(0, 5 * width, 2 * width):
            cells[top : top + side, left + bar : left + bar + width] = 1.0
            lying = left + side + gap
            cells[top + bar : top + bar + width, lying : lying + side] = 1.0
    return Drawing(cells, 0.5)


def _shape(parts: list[tuple[list[Ring], float]]) -> Callable[[float], Drawing]:
    return partial(_draw, parts)


NOTHING = "nothing"
"""The built-in object that is not there: for recording the background alone."""

BUILT_INS: dict[str, Callable[[float], Drawing]] = {
    "letter-B": _shape([(_B, 1.0)]),
    "letter-I": _shape([([_box(0.0, 0.0, 0.25, 1.0)], 1.0)]),
    "letter-T": _shape([([_box(0.0, 0.0, 0.78, 0.22)], 1.0), ([_box(0.27, 0.2, 0.51, 1.0)], 1.0)]),
    "disc": _shape([([_circle(0.5)], 1.0)]),
    "ring": _shape([([_circle(0.5), _circle(0.3)], 1.0)]),
    "square": _shape([([_box(0.0, 0.0, 1.0, 1.0)], 1.0)]),
    "plane": _shape(_PLANE),
    "bars": lambda _height_px: _bars(),
    NOTHING: lambda _height_px: Drawing(np.zeros((1, 1)), 1.0),
}
"""Name to a function of the height in px."""
