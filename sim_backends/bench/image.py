"""A picture made of square cells, and what a grid of square pixels sees of it when it is displaced."""

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
    """``(rows, columns)``: transmission 0 to 1."""

    cell_px: float
    """Side of a cell."""

    left_px: float
    """Image column of the left border where the picture is not displaced."""

    top_px: float
    """Image row of the upper border, likewise."""

    @cached_property
    def _cumulative(self) -> Floats:
        """``(rows + 1, columns + 1)``: light above and left of each cell corner, px squared."""
        padded = np.pad(self.cells, ((1, 0), (1, 0)))
        return padded.cumsum(0).cumsum(1) * self.cell_px**2

    def window(self, dx_px: float, dy_px: float, samples: int, sample_px: float) -> Window:
        """Samples of a ``samples`` x ``samples`` grid that the displaced picture can reach."""
        rows, columns = self.cells.shape

        def reach(border_px: float, cells: int) -> tuple[int, int]:
            first = int(np.floor(border_px / sample_px))
            last = int(np.ceil((border_px + cells * self.cell_px) / sample_px))
            return min(max(first, 0), samples), min(max(last, 0), samples)

        top, bottom = reach(self.top_px + dy_px, rows)
        left, right = reach(self.left_px + dx_px, columns)
        return Window(top, bottom, left, right)

    def light(self, dx_px: float, dy_px: float, window: Window, sample_px: float) -> Floats:
        """``(bottom - top, right - left)``: light on each sample of ``window``, in px squared times transmission."""
        rows, row_part = self._borders(window.top, window.bottom, sample_px, self.top_px + dy_px, 0)
        columns, column_part = self._borders(window.left, window.right, sample_px, self.left_px + dx_px, 1)
        table = self._cumulative
        by_rows = table[rows] * (1 - row_part)[:, None] + table[rows + 1] * row_part[:, None]
        strips = by_rows[1:] - by_rows[:-1]
        by_columns = strips[:, columns] * (1 - column_part) + strips[:, columns + 1] * column_part
        light: Floats = np.maximum(by_columns[:, 1:] - by_columns[:, :-1], 0.0)
        return light

    def _borders(self, first: int, last: int, sample_px: float, border_px: float, axis: int) -> tuple[Integers, Floats]:
        """Cell index and fraction of each sample border along one axis, held at the picture's own borders."""
        cells = self.cells.shape[axis]
        at = np.clip((np.arange(first, last + 1) * sample_px - border_px) / self.cell_px, 0.0, cells)
        index = np.minimum(at.astype(np.int64), cells - 1)
        part = at - index.astype(np.float64)
        return index, part

    def on_grid(self, dx_px: float, dy_px: float, samples: int, sample_px: float) -> Floats:
        """``(samples, samples)``: light on each sample of the whole field."""
        field = np.zeros((samples, samples))
        window = self.window(dx_px, dy_px, samples, sample_px)
        if not window.empty:
            seen = self.light(dx_px, dy_px, window, sample_px)
            field[window.top : window.bottom, window.left : window.right] = seen
        return field
