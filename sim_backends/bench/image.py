"""A picture made of square cells, and what a grid of square pixels sees of it when it is displaced."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from protocols.values import Floats, Integers


@dataclass(frozen=True)
class Window:
    """A rectangle of whole samples: rows ``top`` to ``bottom``, columns ``left`` to ``right``, ends excluded."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def empty(self) -> bool:
        """Whether no sample is inside."""
        return self.bottom <= self.top or self.right <= self.left


@dataclass(frozen=True, eq=False)
class AreaImage:
    """Transmission that is constant on squares and 0 outside them.

    The light on a sample is the integral of the transmission over its area. It is exact at any displacement: the
    double cumulative sum of the cells is bilinear inside each cell. Where a cell is as large as a sample, it is the
    linear interpolation of the picture.
    """

    cells: Floats
    """``(rows, columns)`` transmission of each cell, 0 to 1."""

    cell_px: float
    """Side of a cell in image pixels."""

    left_px: float
    """Image column of the left border where the picture is not displaced."""

    top_px: float
    """Image row of the upper border, likewise."""

    def without_dark_borders(self) -> "AreaImage":
        """Give the same picture without its outermost rows and columns that let nothing through: fewer cells to look at.

        Of a picture that is dark all over, one cell is left.
        """
        rows, columns = np.flatnonzero(self.cells.any(axis=1)), np.flatnonzero(self.cells.any(axis=0))
        (top, bottom), (left, right) = ((int(lit[0]), int(lit[-1])) if len(lit) else (0, 0) for lit in (rows, columns))
        cells = self.cells[top : bottom + 1, left : right + 1]
        return AreaImage(cells, self.cell_px, self.left_px + left * self.cell_px, self.top_px + top * self.cell_px)

    @cached_property
    def _cumulative(self) -> Floats:
        """``(rows + 1, columns + 1)``: light above and left of each cell corner, px squared."""
        padded = np.pad(self.cells, ((1, 0), (1, 0)))
        return padded.cumsum(0).cumsum(1) * self.cell_px**2

    def window(self, at_px: Floats, samples: int, sample_px: float, scale: Floats | None = None) -> Window:
        """Samples of a ``samples`` x ``samples`` grid that the picture reaches at one of ``at_px`` (n, 2) or more."""

        def reach(axis: int) -> tuple[int, int]:
            border_px, cell_px = self._corner(at_px, scale, axis)
            first = math.floor(float(border_px.min()) / sample_px)
            last = math.ceil(float((border_px + self.cells.shape[axis] * cell_px).max()) / sample_px)
            return min(max(first, 0), samples), min(max(last, 0), samples)

        (top, bottom), (left, right) = reach(0), reach(1)
        return Window(top, bottom, left, right)

    def _corner(self, at_px: Floats, scale: Floats | None, axis: int) -> tuple[Floats, Floats | float]:
        """``(n,)`` place of the upper (axis 0) or left (1) border, and the side of a cell."""
        border_px: Floats = (self.top_px, self.left_px)[axis] + at_px[:, 1 - axis]
        if scale is None:
            return border_px, self.cell_px
        half_px = self.cells.shape[axis] * self.cell_px / 2
        return border_px + half_px * (1 - scale), self.cell_px * scale

    def light(self, at_px: Floats, window: Window, sample_px: float, scale: Floats | None = None) -> Floats:
        """Light on each sample of ``window`` while the picture is displaced by ``at_px`` (n, 2: x, y).

        ``scale`` (n,) makes the picture larger about its centre, as bright as before; None is 1.

        Returns:
            ``(n, bottom - top, right - left)``, in px squared times transmission.
        """
        rows, row_part = self._borders(window.top, window.bottom, sample_px, self._corner(at_px, scale, 0), 0)
        columns, column_part = self._borders(window.left, window.right, sample_px, self._corner(at_px, scale, 1), 1)
        table = self._cumulative
        above = table[rows] * (1 - row_part)[:, :, None]
        above += table[rows + 1] * row_part[:, :, None]
        strips = np.diff(above, axis=1)
        before = _columns(strips, columns) * (1 - column_part)[:, None, :]
        before += _columns(strips, columns + 1) * column_part[:, None, :]
        light: Floats = np.maximum(np.diff(before, axis=2), 0.0)
        return light if scale is None else light * (scale**2)[:, None, None]

    def _borders(
        self, first: int, last: int, sample_px: float, corner: tuple[Floats, Floats | float], axis: int
    ) -> tuple[Integers, Floats]:
        """Cell index and fraction of each sample border along one axis, ``(n, borders)``, held at the picture's own."""
        cells, (border_px, cell_px) = self.cells.shape[axis], corner
        at = (np.arange(first, last + 1) * sample_px - border_px[:, None]) / np.reshape(cell_px, (-1, 1))
        at = np.minimum(np.maximum(at, 0.0), cells)
        index = np.minimum(at.astype(np.int64), cells - 1)
        return index, at - index.astype(np.float64)

    def on_grid(
        self, dx_px: float, dy_px: float, samples: int, sample_px: float, scale: Floats | None = None
    ) -> Floats:
        """``(samples, samples)``: light on each sample of the whole field at one displacement, and one ``scale`` (1,)."""
        field = np.zeros((samples, samples))
        at_px = np.array([[dx_px, dy_px]])
        window = self.window(at_px, samples, sample_px, scale)
        if not window.empty:
            seen = self.light(at_px, window, sample_px, scale)[0]
            field[window.top : window.bottom, window.left : window.right] = seen
        return field


def _columns(strips: Floats, columns: Integers) -> Floats:
    """Columns ``columns`` (n, k) of each of ``strips`` (n, rows, any): five times faster than ``take_along_axis``."""
    picked = np.empty((*strips.shape[:2], columns.shape[1]))
    for which in range(len(strips)):
        np.take(strips[which], columns[which], axis=1, out=picked[which], mode="clip")
    return picked
