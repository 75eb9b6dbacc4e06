"""Rows of a moved object in a field that is not evenly lit.

A displaced object sees row k through the brightness L(u + d_k). L is smooth, so that as a matrix over rows k and pixels u it has
a low rank: L(u + d_k) = sum over j of f_j(k) g_j(u), with four terms for a brightness that falls with the square of the
distance from the middle. Evenly lit rows A then become the sum of diag(f_j) A diag(g_j).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.ndimage import map_coordinates

from instrument.numerics import Operator
from instrument.reconstruction.field import Field
from instrument.reconstruction.region import Region
from protocols import Floats, Singles

_NEGLIGIBLE = 1e-3  # of the largest singular value: smaller terms change a value by less than a thousandth
_ROWS, _PIXELS = 24, 16  # rows, and pixels an axis, from which the terms are found


@dataclass(frozen=True, eq=False)
class Brightness:
    """The terms of L(u + d_k)."""

    of_rows: Singles
    """``(terms, rows)``: f_j."""

    of_pixels: Singles
    """``(terms, height, width)``: g_j."""

    @classmethod
    def of(cls, profile: Floats, places_px: Floats, field: Field, region: Region) -> Self:
        """Find the terms for the places of an object.

        Args:
            profile: ``(size, size)`` brightness of each pattern pixel.
            places_px: ``(rows, 2)`` displacement of the object, x and y.
            field: field, and the grid of the image.
            region: pattern pixels of the image.
        """
        down, across = (
            first + (np.arange(count * field.grid) + 0.5) / field.grid - 0.5
            for first, count in ((region.top, region.height), (region.left, region.width))
        )

        def seen(places: Floats, rows: Floats, columns: Floats) -> Floats:
            """``(places, rows columns)``: brightness of pixels of a displaced object, beyond the field that of its border."""
            y, x = rows[None, :, None] + places[:, 1, None, None], columns[None, None, :] + places[:, 0, None, None]
            found = map_coordinates(profile, np.broadcast_arrays(y, x), order=1, mode="nearest")
            return np.asarray(found.reshape(len(places), -1), np.float64)

        some_down, some_across = (
            along[np.linspace(0, len(along) - 1, min(_PIXELS, len(along))).round().astype(np.int64)]
            for along in (down, across)
        )
        few = np.linspace(0, len(places_px) - 1, min(_ROWS, len(places_px))).round().astype(np.int64)
        _, sizes, along_pixels = np.linalg.svd(seen(places_px[few], some_down, some_across), full_matrices=False)
        terms = max(1, int(np.count_nonzero(sizes > _NEGLIGIBLE * sizes[0])))
        of_rows = seen(places_px, some_down, some_across) @ along_pixels[:terms].T
        of_pixels = np.linalg.lstsq(of_rows[few], seen(places_px[few], down, across), rcond=None)[0]
        shape = (terms, len(down), len(across))
        return cls(of_rows.T.astype(np.float32), of_pixels.reshape(shape).astype(np.float32))


@dataclass(frozen=True, eq=False)
class Lit:
    """Rows of another operator with one image, each seen through the brightness of the object's place."""

    operator: Operator
    """The rows in a field that is evenly lit."""

    brightness: Brightness
    """The terms of the brightness."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of pixels."""
        return self.operator.shape

    @property
    def image_shapes(self) -> tuple[tuple[int, int], ...]:
        """Height and width of the one unknown image, in image pixels."""
        return self.operator.image_shapes

    def matvec(self, image: Singles) -> Singles:
        """Give the values of an image: ``(pixels,)`` to ``(rows,)``."""
        values = np.zeros(self.shape[0], np.float32)
        for of_rows, of_pixels in zip(self.brightness.of_rows, self.brightness.of_pixels, strict=True):
            values += of_rows * self.operator.matvec(of_pixels.ravel() * image)
        return values

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        image = np.zeros(self.shape[1], np.float32)
        for of_rows, of_pixels in zip(self.brightness.of_rows, self.brightness.of_pixels, strict=True):
            image += of_pixels.ravel() * self.operator.rmatvec(of_rows * values)
        return image
