"""The part of the field that an object can occupy while it stays inside the field."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from protocols import Floats, InputError

_SMALLEST_PX = 4


@dataclass(frozen=True)
class Region:
    """A rectangle of whole image pixels."""

    top: int
    """First row."""

    left: int
    """First column."""

    height: int
    """Number of rows."""

    width: int
    """Number of columns."""

    @classmethod
    def whole(cls, size: int) -> Self:
        """Give the whole field of ``size`` pixels a side."""
        return cls(0, 0, size, size)

    @classmethod
    def inside(cls, displacement_px: Floats, size: int) -> Self:
        """Give the pixels of an object, at its position in frame 0, that every displacement leaves inside the field.

        Along each axis they reach from max(0, -min d) to size - max(0, max d), widened to whole pixels.

        Args:
            displacement_px: ``(n, 2)`` displacements (x, y) relative to frame 0.
            size: pixels a side of the field.

        Raises:
            InputError: the displacements leave no room for an object.
        """
        low = np.maximum(0.0, -displacement_px.min(axis=0))
        high = size - np.maximum(0.0, displacement_px.max(axis=0))
        left, top = np.floor(low).astype(int).tolist()
        right, bottom = np.ceil(high).astype(int).tolist()
        if min(right - left, bottom - top) < _SMALLEST_PX:
            raise InputError(
                saw=f"displacements of {np.ptp(displacement_px, axis=0).round(1).tolist()} px (x, y) in a field of {size} px",
                expected="an object that stays inside the field all the time",
                remedy="keep the object inside the field, or record fewer frames; from Python, try region=False",
            )
        return cls(top, left, bottom - top, right - left)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, in pixels."""
        return self.height, self.width

    def room(self, size: int) -> tuple[int, int]:
        """Give the numbers of pixels to the right of this region and below it, in a field of ``size`` pixels a side."""
        return size - self.left - self.width, size - self.top - self.height

    def stays(self, displacement_px: Floats, size: int) -> bool:
        """Whether none of the displacements, ``(n, 2)``, takes a part of it out of a field by a pixel or more."""
        low, high = displacement_px.min(axis=0), displacement_px.max(axis=0)
        return bool((low > [-1 - self.left, -1 - self.top]).all() and (high < np.array(self.room(size)) + 1).all())

    def grown(self, px: int, size: int) -> "Region":
        """Give it with so many more pixels at each side, as far as the field goes."""
        top, left = max(self.top - px, 0), max(self.left - px, 0)
        bottom, right = min(self.top + self.height + px, size), min(self.left + self.width + px, size)
        return Region(top, left, bottom - top, right - left)

    def paste(self, part: Floats, size: int) -> Floats:
        """Give an image of the whole field, zeros with ``part`` at this region.

        Args:
            part: ``(grid height, grid width)``, any whole number of image pixels a pixel side.
            size: pixels a side of the field.

        Returns:
            ``(grid size, grid size)``.
        """
        grid = part.shape[0] // self.height
        image = np.zeros((grid * size, grid * size))
        top, left = grid * self.top, grid * self.left
        image[top : top + part.shape[0], left : left + part.shape[1]] = part
        return image
