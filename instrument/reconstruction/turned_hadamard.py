"""The measurement matrix of an object that moved and turned, written out row by row.

A turned Hadamard pattern is no outer product any more, so that its row has an entry of its own for each image pixel: the product
of both Walsh rows, read where the pixel is at the time. Between two entries they are read by linear interpolation, which for an
object that has not turned is exact, as pixels are square; a turned pixel is taken for one that covers the same light around the
same middle.
"""

from dataclasses import dataclass

import numpy as np

from instrument.numerics import compiled, inlined
from instrument.reconstruction.field import Field, padded_walsh
from instrument.reconstruction.region import Region
from protocols import Floats, Integers, Singles


@dataclass(frozen=True, eq=False)
class TurnedRows:
    """Hadamard patterns as an object sees them whose pivot is displaced, and which has turned about it."""

    walsh: Singles
    """``(size, 3 size + 2)``: the Walsh rows as they act, with size + 1 zeros on both sides."""

    pairs: Integers
    """``(rows, 2)``: Walsh rows (c_i down, c_j across) of each pattern."""

    pose: Floats
    """``(rows, 3)``: displacement x, y of the pivot in px, and angle in radians, from x to y."""

    pivot_px: Floats
    """``(2,)``: x, y of the pivot where it is not displaced."""

    region: Region
    """Pixels of the image where it has not moved; the image is 0 elsewhere."""

    @classmethod
    def of(cls, field: Field, pairs: Integers, pose: Floats, pivot_px: Floats, region: Region) -> "TurnedRows":
        """Prepare the rows of some patterns on the patterns' own grid."""
        walsh = np.ascontiguousarray(padded_walsh(Field(field.size, 1, field.edge_loss)))
        return cls(walsh, np.ascontiguousarray(pairs), np.ascontiguousarray(pose, np.float64), pivot_px, region)

    def matrix(self) -> Singles:
        """Give the rows, ``(rows, height width)``."""
        area = self.region
        matrix = np.empty((len(self.pairs), area.height * area.width), np.float32)
        _fill(self.walsh, self.pairs, self.pose, *self._corner(), area.width, matrix)
        return matrix

    def values(self, image: Singles) -> tuple[Floats, Floats]:
        """Give the values of an image, ``(rows,)``, and their derivatives by x, y (1/px) and angle, ``(rows, 3)``."""
        values, slopes = np.zeros(len(self.pairs)), np.zeros((len(self.pairs), 3))
        pixels = np.ascontiguousarray(image, np.float32)
        _values(self.walsh, self.pairs, self.pose, *self._corner(), pixels, values, slopes)
        return values, slopes

    def _corner(self) -> tuple[float, float, float, float]:
        """Give the first pixel's middle against the pivot, and the pivot's place, x and y each."""
        x, y = self.pivot_px.tolist()
        return self.region.left - x, self.region.top - y, x, y


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
    size = walsh.shape[0]
    for k in range(matrix.shape[0]):
        cos, sin = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        down, across = walsh[pairs[k, 0]], walsh[pairs[k, 1]]
        for pixel in range(matrix.shape[1]):
            u, v = left + pixel % width, top + pixel // width
            y, _ = _read(down, pivot_y + pose[k, 1] + u * sin + v * cos, size)
            x, _ = _read(across, pivot_x + pose[k, 0] + u * cos - v * sin, size)
            matrix[k, pixel] = x * y


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
    size = walsh.shape[0]
    for k in range(len(values)):
        cos, sin = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        down, across = walsh[pairs[k, 0]], walsh[pairs[k, 1]]
        for row in range(image.shape[0]):
            for column in range(image.shape[1]):
                light = image[row, column]
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
