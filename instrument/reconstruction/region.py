"""The pixels of an object that are unknown: those that stay inside the field, or all that the field ever sees."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from protocols import Floats, InputError

_SMALLEST_PX = 4


@dataclass(frozen=True)
class Region:
    """A rectangle of whole pattern pixels, counted from the field's upper left one at frame 0. It may reach outside the field."""

    top: int
    """First row."""

    left: int
    """First column."""

    height: int
    """Number of rows."""

    width: int
    """Number of columns."""

    def __post_init__(self) -> None:
        """Refuse a rectangle without pixels."""
        if self.height < 1 or self.width < 1:
            raise InputError(
                saw=f"a region of {self.height} x {self.width} px",
                expected="a height and a width of 1 px or more",
                remedy="correct it",
            )

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
                remedy='keep the object inside the field, or record fewer frames; of one that passes by, try the region "wide"',
            )
        return cls(top, left, bottom - top, right - left)

    @classmethod
    def seen(cls, displacement_px: Floats, size: int) -> Self:
        """Give the pixels of an object, at its position in frame 0, of which the field sees a part at one displacement or more.

        Along each axis they reach from -max d to size - min d, widened to whole pixels: of an object that passes by, the field
        sees more than its own size.

        Args:
            displacement_px: ``(n, 2)`` displacements (x, y) relative to frame 0.
            size: pixels a side of the field.
        """
        left, top = np.floor(-displacement_px.max(axis=0)).astype(int).tolist()
        right, bottom = np.ceil(size - displacement_px.min(axis=0)).astype(int).tolist()
        return cls(top, left, bottom - top, right - left)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, in pixels."""
        return self.height, self.width

    def room(self, size: int) -> tuple[int, int]:
        """Give the numbers of pixels to the right of this region and below it, in a field of ``size`` pixels a side."""
        return size - self.left - self.width, size - self.top - self.height

    def with_field(self, size: int) -> "Region":
        """Give the smallest rectangle that holds this region and a field of ``size`` pixels a side."""
        top, left = min(self.top, 0), min(self.left, 0)
        bottom, right = max(self.top + self.height, size), max(self.left + self.width, size)
        return Region(top, left, bottom - top, right - left)

    def within(self, outer: "Region") -> tuple[slice, slice]:
        """Give the rows and columns of this region in an image of a larger one."""
        top, left = self.top - outer.top, self.left - outer.left
        return slice(top, top + self.height), slice(left, left + self.width)

    def stays(self, displacement_px: Floats, size: int) -> bool:
        """Whether none of the displacements, ``(n, 2)``, takes a part of it out of a field by a pixel or more."""
        low, high = displacement_px.min(axis=0), displacement_px.max(axis=0)
        return bool((low > [-1 - self.left, -1 - self.top]).all() and (high < np.array(self.room(size)) + 1).all())

    def wider(self, px: int) -> "Region":
        """Give it with so many more pixels at each side, whatever the field."""
        return Region(self.top - px, self.left - px, self.height + 2 * px, self.width + 2 * px)

    def grown(self, px: int, size: int) -> "Region":
        """Give it with so many more pixels at each side, as far as the field goes."""
        top, left = max(self.top - px, 0), max(self.left - px, 0)
        bottom, right = min(self.top + self.height + px, size), min(self.left + self.width + px, size)
        return Region(top, left, bottom - top, right - left)

    def paste(self, part: Floats, size: int) -> Floats:
        """Give an image of the whole field, zeros with ``part`` at this region; a larger one where the region reaches outside.

        Args:
            part: ``(grid height, grid width)``, any whole number of image pixels a pixel side.
            size: pixels a side of the field.

        Returns:
            ``(grid rows, grid columns)`` of ``with_field``: ``(grid size, grid size)`` where the region is inside.
        """
        grid = part.shape[0] // self.height
        whole = self.with_field(size)
        image = np.zeros((grid * whole.height, grid * whole.width))
        top, left = grid * (self.top - whole.top), grid * (self.left - whole.left)
        image[top : top + part.shape[0], left : left + part.shape[1]] = part
        return image
