"""An image that turns and grows while a run goes on: yaw of a stage, a way that leaves the plane of focus."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from protocols import Floats, Integers
from sim_backends.bench.image import AreaImage

_STEP_PX: Final = 1 / 32
"""The image turns in steps that move its corners by so many pixels,"""

_MOST_STEPS: Final = 1000
"""but in so many steps at most."""

_CELL_PX: Final = 0.5
"""Side of a cell of the turned image, at most. Taking the mean over it blurs an image by 0.2 px where it is turned."""

_SAMPLES: Final = 4
"""Transmission is read at so many places along the side of such a cell, which takes their mean."""

_MOST_CELLS: Final = 400
"""Cells along the diagonal: an image that is larger than 200 px is turned on coarser ones."""

_KEPT: Final = 4
"""Turned images to keep. Time goes on, so that older ones are not needed again."""


@dataclass(frozen=True, eq=False)
class ChangingImage:
    """An image that changes at a constant rate about the centre of its rectangle, from the first sync edge on."""

    image: AreaImage
    """As it is at the first sync edge."""

    growth: float = 0.0
    """Relative growth in ``run_s``. Its brightness stays."""

    turn_deg: float = 0.0
    """Degrees in ``run_s``, clockwise as one looks at the picture."""

    run_s: float = 1.0
    """Duration of the run, in seconds."""

    _turned: dict[int, AreaImage] = field(init=False, default_factory=dict[int, AreaImage])

    def scale(self, time_s: Floats) -> Floats | None:
        """``(n,)`` size at ``time_s`` (n,), as a part of that at the first sync edge; None where it never changes."""
        return 1 + self.growth * (time_s / self.run_s) if self.growth else None

    def poses(self, time_s: Floats) -> Iterator[tuple[Integers, AreaImage]]:
        """The image as it is turned, with the indices of the ``time_s`` (n,) at which it is."""
        if not self.turn_deg:
            yield np.arange(len(time_s)), self.image
            return
        height, width = (side * self.image.cell_px for side in self.image.cells.shape)
        fine_deg = math.degrees(_STEP_PX / (math.hypot(height, width) / 2))
        step_deg = max(fine_deg, abs(self.turn_deg) / _MOST_STEPS)
        steps = np.rint(self.turn_deg * (time_s / self.run_s) / step_deg).astype(np.int64)
        for step in np.unique(steps):
            yield np.flatnonzero(steps == step), self._at(int(step), step_deg)

    def _at(self, step: int, step_deg: float) -> AreaImage:
        if step not in self._turned:
            while len(self._turned) >= _KEPT:
                del self._turned[next(iter(self._turned))]
            self._turned[step] = turned(self.image, step * step_deg)
        return self._turned[step]

    def on_grid(self, time_s: float, at_px: Floats, image_size: int) -> Floats:
        """``(image_size, image_size)``: transmission at one moment, displaced by ``at_px`` (2,)."""
        now_s = np.array([time_s])
        ((_, image),) = self.poses(now_s)
        return image.on_grid(float(at_px[0]), float(at_px[1]), image_size, 1.0, self.scale(now_s))


def turned(image: AreaImage, degrees: float) -> AreaImage:
    """Turn an image about the centre of its rectangle, on cells of half a pixel or less.

    A turn from x (right) towards y (down), clockwise as one looks at it, takes (u, v) to (u cos - v sin, u sin + v cos).
    """
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    height, width = (side * image.cell_px for side in image.cells.shape)
    finest_px = max(_CELL_PX, math.hypot(height, width) / _MOST_CELLS)
    parts = math.ceil(image.cell_px / finest_px)
    cell_px = image.cell_px / parts
    fine = math.ceil(cell_px / finest_px * _SAMPLES)
    high = _enough(image.cells.shape[0] * parts, abs(height * cos) + abs(width * sin), cell_px)
    wide = _enough(image.cells.shape[1] * parts, abs(width * cos) + abs(height * sin), cell_px)
    x = ((np.arange(wide * fine) + 0.5) / fine - wide / 2) * cell_px
    y = ((np.arange(high * fine) + 0.5) / fine - high / 2)[:, None] * cell_px
    column = np.floor((x * cos + y * sin + width / 2) / image.cell_px).astype(np.int64)
    row = np.floor((y * cos - x * sin + height / 2) / image.cell_px).astype(np.int64)
    # A rim of dark cells takes what lies outside.
    cells = np.pad(image.cells, 1)
    rows, columns = cells.shape
    seen = cells[np.clip(row + 1, 0, rows - 1), np.clip(column + 1, 0, columns - 1)]
    means: Floats = seen.reshape(high, fine, wide, fine).mean(axis=(1, 3))
    left_px, top_px = image.left_px + (width - wide * cell_px) / 2, image.top_px + (height - high * cell_px) / 2
    return AreaImage(means, cell_px, left_px, top_px)


def _enough(cells: int, needed_px: float, cell_px: float) -> int:
    """Cells for ``needed_px``: ``cells``, or as many more to either side as it takes."""
    return cells + 2 * max(0, math.ceil((needed_px / cell_px - cells) / 2 - 1e-9))
