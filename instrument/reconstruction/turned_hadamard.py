"""The measurement matrix of an object that moved, turned and grew, written out row by row.

A turned Hadamard pattern is no outer product any more, so that its row has an entry of its own for each image pixel: the product
of both Walsh rows, read where the pixel is at the time. Between two entries they are read by linear interpolation, which for an
object that has not turned is exact, as pixels are square; a turned pixel is taken for one that covers the same light around the
same middle, and so is one that has grown, whose light is then that of its larger area.
"""

from dataclasses import dataclass

import numpy as np

from instrument.numerics import compiled, inlined
from instrument.reconstruction.field import Field, padded_walsh
from instrument.reconstruction.region import Region
from protocols import Floats, Integers, Singles


@dataclass(frozen=True, eq=False)
class TurnedRows:
    """Hadamard patterns as an object sees them whose pivot is displaced, and which has turned and grown about it."""

    field: Field
    """Field, and the grid of the image."""

    pairs: Integers
    """``(rows, 2)``: Walsh rows (c_i down, c_j across) of each pattern."""

    pose: Floats
    """``(rows, 4)``: displacement x, y of the pivot in px, angle in radians, from x to y, and logarithm of the magnification."""

    pivot_px: Floats
    """``(2,)``: x, y of the pivot where it is not displaced."""

    region: Region
    """Pixels of the image where it has not moved; the image is 0 elsewhere."""

    def matrix(self) -> Singles:
        """Give the rows, ``(rows, height width)`` image pixels."""
        height, width = self.image_shape
        matrix = np.empty((len(self.pairs), height * width), np.float32)
        walsh, pairs, pose, corner = self._on_grid()
        _fill(walsh, pairs, pose, *corner, width, matrix)
        return matrix

    def values(self, image: Singles) -> tuple[Floats, Floats]:
        """Give the values of an image, and their derivatives.

        Args:
            image: ``(height, width)`` image pixels of the region.

        Returns:
            The values, ``(rows,)``, and their derivatives by x, y (1/px), angle and logarithm of the magnification,
            ``(rows, 4)``.
        """
        values, slopes = np.zeros(len(self.pairs)), np.zeros((len(self.pairs), 4))
        walsh, pairs, pose, corner = self._on_grid()
        _values(walsh, pairs, pose, *corner, np.ascontiguousarray(image, np.float32), values, slopes)
        slopes[:, :2] *= self.field.grid
        return values, slopes

    @property
    def image_shape(self) -> tuple[int, int]:
        """Height and width of the image, in image pixels."""
        return self.region.height * self.field.grid, self.region.width * self.field.grid

    def _on_grid(self) -> tuple[Singles, Integers, Floats, tuple[float, float, float, float]]:
        """Give the padded Walsh rows, the pairs, the poses in image pixels, and with them the corner of ``corner_of``."""
        pose = np.array(self.pose, np.float64, order="C")
        pose[:, :2] *= self.field.grid
        pairs = np.ascontiguousarray(self.pairs)
        return padded_walsh(self.field), pairs, pose, corner_of(self.field, self.region, self.pivot_px)


def corner_of(field: Field, region: Region, pivot_px: Floats) -> tuple[float, float, float, float]:
    """Give the first image pixel's middle against the pivot, and the pivot's place, x and y each, in image pixels."""
    x, y = ((pivot_px + 0.5) * field.grid - 0.5).tolist()
    return region.left * field.grid - x, region.top * field.grid - y, x, y


@inlined
def _read(row: Singles, place: float, size: int) -> tuple[float, float]:
    """Give a padded Walsh row at a place, by linear interpolation, and its derivative."""
    at = place + (size + 1)
    if at < 0.0 or at >= 3 * size + 1:
        return 0.0, 0.0
    whole = int(at)
    near, step = row[whole], row[whole + 1] - row[whole]
    return near + (at - whole) * step, step


@compiled("void(f4[:, ::1], i8[:, ::1], f8[:, ::1], f8, f8, f8, f8, i8, f4[:, ::1])")
def _fill(  # noqa: PLR0917
    walsh: Singles,
    pairs: Integers,
    pose: Floats,
    left: float,
    top: float,
    pivot_x: float,
    pivot_y: float,
    width: int,
    matrix: Singles,
) -> None:
    """Write the rows of ``TurnedRows.matrix``."""
    size = (walsh.shape[1] - 2) // 3
    for k in range(matrix.shape[0]):
        larger = np.exp(pose[k, 3])
        cos, sin, area = larger * np.cos(pose[k, 2]), larger * np.sin(pose[k, 2]), larger * larger
        down, across = walsh[pairs[k, 0]], walsh[pairs[k, 1]]
        for pixel in range(matrix.shape[1]):
            u, v = left + pixel % width, top + pixel // width
            y, _ = _read(down, pivot_y + pose[k, 1] + u * sin + v * cos, size)
            x, _ = _read(across, pivot_x + pose[k, 0] + u * cos - v * sin, size)
            matrix[k, pixel] = area * (x * y)


@compiled("void(f4[:, ::1], i8[:, ::1], f8[:, ::1], f8, f8, f8, f8, f4[:, ::1], f8[::1], f8[:, ::1])")
def _values(  # noqa: PLR0917
    walsh: Singles,
    pairs: Integers,
    pose: Floats,
    left: float,
    top: float,
    pivot_x: float,
    pivot_y: float,
    image: Singles,
    values: Floats,
    slopes: Floats,
) -> None:
    """Add up what ``TurnedRows.values`` gives."""
    size = (walsh.shape[1] - 2) // 3
    for k in range(len(values)):
        larger = np.exp(pose[k, 3])
        cos, sin, area = larger * np.cos(pose[k, 2]), larger * np.sin(pose[k, 2]), larger * larger
        down, across = walsh[pairs[k, 0]], walsh[pairs[k, 1]]
        for row in range(image.shape[0]):
            for column in range(image.shape[1]):
                light = area * image[row, column]
                if light == 0.0:
                    continue
                u, v = left + column, top + row
                u, v = u * cos - v * sin, u * sin + v * cos
                y, slope_y = _read(down, pivot_y + pose[k, 1] + v, size)
                x, slope_x = _read(across, pivot_x + pose[k, 0] + u, size)
                values[k] += light * x * y
                slopes[k, 0] += light * slope_x * y
                slopes[k, 1] += light * x * slope_y
                slopes[k, 2] += light * (x * slope_y * u - slope_x * y * v)
                slopes[k, 3] += light * (2 * x * y + slope_x * y * u + x * slope_y * v)


@dataclass(frozen=True, eq=False)
class DenseRows:
    """A matrix of whitened rows, as an operator."""

    matrix: Singles
    """``(rows, height width)``."""

    image_shape: tuple[int, int]
    """Height and width of the image."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of pixels."""
        return self.matrix.shape[0], self.matrix.shape[1]

    @property
    def image_shapes(self) -> tuple[tuple[int, int]]:
        """Height and width of the one unknown image, in pixels."""
        return (self.image_shape,)

    def matvec(self, image: Singles) -> Singles:
        """Give the values of an image: ``(pixels,)`` to ``(rows,)``."""
        return np.asarray(self.matrix @ image, np.float32)

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        return np.asarray(values @ self.matrix, np.float32)
