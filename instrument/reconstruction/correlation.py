"""Values that fixed patterns give of an image at any displacement: correlation maps."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.sparse import csr_array

from instrument.reconstruction.field import Field
from instrument.reconstruction.region import Region
from protocols import Floats, Integers, Singles


@dataclass(frozen=True, eq=False)
class _Cells:
    """Where displacements lie in the maps: between a near and a far entry along each axis. All arrays have one shape."""

    x: Integers
    """Near column."""

    y: Integers
    """Near row."""

    far_x: Integers
    """Column after the near one."""

    far_y: Integers
    """Row after the near one."""

    part_x: Floats
    """Distance from the near column in image pixels, 0 to 1."""

    part_y: Floats
    """Distance from the near row in image pixels, 0 to 1."""


@dataclass(frozen=True, eq=False)
class FixedPatterns:
    """Patterns that are the same in every frame, such as the four Fourier patterns.

    The value of pattern P on an image O displaced by d is the correlation C(d) = sum O(u) P(u + d), P being 0 outside the field.
    At whole image pixels one Fourier transform gives C for all d. Between them C is linear along each axis, exactly, as pixels
    are square.
    """

    patterns: Singles
    """``(n, pixels, pixels)``: weight of each image pixel, as ``Field.acting`` gives it."""

    field: Field
    """Field, and the grid of the image."""

    region: Region
    """Pattern pixels where the image may differ from 0."""

    width: int
    """Width and height of the maps: 2 pixels where they hold all displacements, less where only some are needed, and more for a
    region that reaches outside the field."""

    @classmethod
    def of(cls, patterns: Singles, field: Field, region: Region, places_px: Floats | None = None) -> Self:
        """Prepare patterns as they act, dithering included.

        Args:
            patterns: ``(n, pixels, pixels)``, such as ``field.acting`` gives.
            field: field, and the grid of the image.
            region: pattern pixels of the image.
            places_px: ``(..., 2)`` all displacements (x, y) that will be asked for. Where the region stays inside the field at
                all of them, the maps are a quarter as large. None allows any displacement.
        """
        inside = places_px is not None and region.stays(places_px.reshape(-1, 2), field.size)
        width = int(fft.next_fast_len(field.pixels + 2 * field.grid, real=True)) if inside else 2 * field.pixels
        side = max(region.with_field(field.size).shape)
        if side > field.size:
            width = int(fft.next_fast_len(field.pixels + side * field.grid, real=True))
        return cls(patterns, field, region, width)

    @cached_property
    def _spectra(self) -> NDArray[np.complex64]:
        """``(n, width, width // 2 + 1)``: Fourier transforms of the patterns."""
        spectra: NDArray[np.complex64] = fft.rfft2(self.patterns, (self.width, self.width))
        return spectra

    def maps(self, image: Singles) -> Singles:
        """Give C at whole displacements, ``(n, width, width)``, negative displacements counted from the end.

        Displacements are those of the corner of ``_canvas``, which is that of the field unless the region reaches outside.

        Args:
            image: ``(height, width)`` image pixels of the region.
        """
        padded = np.zeros(tuple(side * self.field.grid for side in self._canvas.shape), np.float32)
        padded[self._inside] = image
        seen = np.conj(fft.rfft2(padded, (self.width, self.width))) * self._spectra
        maps: Singles = fft.irfft2(seen, (self.width, self.width))
        return maps

    def image(self, maps: Singles) -> Singles:
        """Apply the transpose of ``maps``: ``(n, width, width)`` to ``(height, width)`` of the region."""
        seen: NDArray[np.complex64] = fft.rfft2(maps)
        together: NDArray[np.complex64] = (np.conj(seen) * self._spectra).sum(axis=0)
        image: Singles = fft.irfft2(together, (self.width, self.width))
        return image[self._inside]

    @cached_property
    def _canvas(self) -> Region:
        """The field, with what of the region is outside it."""
        return self.region.with_field(self.field.size)

    @property
    def _inside(self) -> tuple[slice, slice]:
        """Rows and columns of the region in the canvas, in image pixels."""
        grid = self.field.grid
        rows, columns = self.region.within(self._canvas)
        return slice(rows.start * grid, rows.stop * grid), slice(columns.start * grid, columns.stop * grid)

    def values(self, maps: Singles, places_px: Floats) -> tuple[Floats, Floats]:
        """Read maps at displacements, by linear interpolation.

        Args:
            maps: ``(n, width, width)`` maps of the image.
            places_px: ``(rows, n, 2)`` displacement (x, y) during each pattern in each row.

        Returns:
            The values, ``(rows, n)``, and their derivatives by x and y, ``(rows, n, 2)``.
        """
        cells, pattern = self._cells(places_px), np.arange(len(self.patterns))
        near, right = maps[pattern, cells.y, cells.x], maps[pattern, cells.y, cells.far_x]
        down, both = maps[pattern, cells.far_y, cells.x], maps[pattern, cells.far_y, cells.far_x]
        upper, lower = near + cells.part_x * (right - near), down + cells.part_x * (both - down)
        slope_x = (1 - cells.part_y) * (right - near) + cells.part_y * (both - down)
        values: Floats = (upper + cells.part_y * (lower - upper)).astype(np.float64)
        slopes: Floats = np.stack([slope_x, lower - upper], axis=-1).astype(np.float64)
        return values, slopes * self.field.grid

    def sampling(self, places_px: Floats) -> csr_array:
        """Give the sparse matrix, ``(rows n, n width width)``, that takes ``maps.ravel()`` to ``values``."""
        cells, first = self._cells(places_px), np.arange(len(self.patterns)) * self.width**2
        along_y = ((cells.y, 1 - cells.part_y), (cells.far_y, cells.part_y))
        along_x = ((cells.x, 1 - cells.part_x), (cells.far_x, cells.part_x))
        columns = [first + y * self.width + x for y, _ in along_y for x, _ in along_x]
        weights = [weight_y * weight_x for _, weight_y in along_y for _, weight_x in along_x]
        rows = np.tile(np.arange(cells.x.size), len(weights))
        entries = np.stack(weights).astype(np.float32).ravel(), (rows, np.stack(columns).ravel())
        return csr_array(entries, shape=(cells.x.size, len(self.patterns) * self.width**2))

    def _cells(self, places_px: Floats) -> _Cells:
        """Find where displacements, ``(..., 2)``, lie in the maps."""
        pixels, grid, canvas = self.field.pixels, self.field.grid, self._canvas
        corner = (places_px + np.array([canvas.left, canvas.top], np.float64)) * grid
        first = -grid * np.array([canvas.width, canvas.height])
        places = np.clip(corner, first, pixels - 1e-6)  # from there on the object is outside the field
        whole = np.floor(places).astype(np.int64)
        part = places - whole
        near, far = whole % self.width, (whole + 1) % self.width
        return _Cells(near[..., 0], near[..., 1], far[..., 0], far[..., 1], part[..., 0], part[..., 1])
