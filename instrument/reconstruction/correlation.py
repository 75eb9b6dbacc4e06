"""What fixed patterns see of an image, wherever it is: correlation maps."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.sparse import csr_array

from instrument.reconstruction.region import Region
from protocols import Bytes, Floats, Integers, Singles

Pair: TypeAlias = tuple[Integers, Integers]


@dataclass(frozen=True, eq=False)
class FixedPatterns:
    """Patterns that are the same in every frame, such as the four Fourier patterns.

    The value of pattern P on an image O displaced by d is the correlation C(d) = sum O(u) P(u + d), P zero outside the field. At
    whole pixels that is one Fourier transform for all d; between them C is linear along each axis, exactly, for square pixels.
    """

    patterns: Singles
    """``(n, size, size)``: 0 to 1; where a pixel has several dithered samples, their mean."""

    region: Region
    """Where the image may differ from 0."""

    width: int
    """Of the maps: 2 size for all displacements, less where few are needed."""

    @classmethod
    def of(cls, patterns: Bytes, size: int, region: Region, places_px: Floats | None = None) -> Self:
        """Prepare binary patterns as they were shown, dithering included.

        Args:
            patterns: ``(n, samples, samples)`` of 0 and 1, samples a multiple of ``size``.
            size: pixels a side of the field.
            region: of the image.
            places_px: ``(..., 2)`` x, y: all displacements that will be asked for; where the region stays inside the field at
                all of them, maps are a quarter as large.
        """
        finer = patterns.shape[-1] // size
        samples = patterns.reshape(-1, size, finer, size, finer)
        inside = False
        if places_px is not None:
            every_px = places_px.reshape(-1, 2)
            low, high = every_px.min(axis=0) > np.array([-1 - region.left, -1 - region.top]), every_px.max(axis=0)
            inside = bool(low.all() and (high < np.array(region.room(size)) + 1).all())
        width = int(fft.next_fast_len(size + 2, real=True)) if inside else 2 * size
        return cls(samples.mean(axis=(2, 4)).astype(np.float32), region, width)

    @cached_property
    def _spectra(self) -> NDArray[np.complex64]:
        spectra: NDArray[np.complex64] = fft.rfft2(self.patterns, (self.width, self.width))
        return spectra

    def maps(self, image: Singles) -> Singles:
        """``(n, width, width)``: C at whole displacements, negative ones counted from the end.

        Args:
            image: ``(height, width)`` of the region.
        """
        padded = np.zeros(self.patterns.shape[1:], np.float32)
        padded[self._inside] = image
        seen = np.conj(fft.rfft2(padded, (self.width, self.width))) * self._spectra
        maps: Singles = fft.irfft2(seen, (self.width, self.width))
        return maps

    def image(self, maps: Singles) -> Singles:
        """The transpose of ``maps``: from ``(n, width, width)`` to ``(height, width)`` of the region."""
        seen: NDArray[np.complex64] = fft.rfft2(maps)
        together: NDArray[np.complex64] = (np.conj(seen) * self._spectra).sum(axis=0)
        image: Singles = fft.irfft2(together, (self.width, self.width))
        return image[self._inside]

    @property
    def _inside(self) -> tuple[slice, slice]:
        area = self.region
        return slice(area.top, area.top + area.height), slice(area.left, area.left + area.width)

    def values(self, maps: Singles, places_px: Floats) -> tuple[Floats, Floats]:
        """Read maps at displacements.

        Args:
            maps: of the image.
            places_px: ``(rows, n, 2)`` x, y: of each pattern in each row.

        Returns:
            ``(rows, n)`` values, and ``(rows, n, 2)`` their derivatives by x and y.
        """
        (x, y), (next_x, next_y), (across_px, down_px) = self._cells(places_px)
        pattern = np.arange(len(self.patterns))
        near, right = maps[pattern, y, x], maps[pattern, y, next_x]
        down, both = maps[pattern, next_y, x], maps[pattern, next_y, next_x]
        upper, lower = near + across_px * (right - near), down + across_px * (both - down)
        slope_x = (1 - down_px) * (right - near) + down_px * (both - down)
        values: Floats = (upper + down_px * (lower - upper)).astype(np.float64)
        slopes: Floats = np.stack([slope_x, lower - upper], axis=-1).astype(np.float64)
        return values, slopes

    def sampling(self, places_px: Floats) -> csr_array:
        """Reading maps as a sparse matrix, ``(rows n, n width width)``: ``values`` of ``maps.ravel()``."""
        (x, y), (next_x, next_y), (across_px, down_px) = self._cells(places_px)
        first = np.arange(len(self.patterns)) * self.width**2
        columns = [first + down * self.width + across for down in (y, next_y) for across in (x, next_x)]
        weights = [down * across for down in (1 - down_px, down_px) for across in (1 - across_px, across_px)]
        rows = np.tile(np.arange(x.size), 4)
        entries = np.stack(weights).astype(np.float32).ravel(), (rows, np.stack(columns).ravel())
        return csr_array(entries, shape=(x.size, len(self.patterns) * self.width**2))

    def _cells(self, places_px: Floats) -> tuple[Pair, Pair, tuple[Floats, Floats]]:
        """Column and row of each place in the maps, those after, and the parts of a pixel between."""
        size = self.patterns.shape[-1]
        places = np.clip(places_px, -size, size - 1e-6)  # farther away there is nothing left to see
        whole = np.floor(places).astype(np.int64)
        part = places - whole
        here, after = whole % self.width, (whole + 1) % self.width
        return (here[..., 0], here[..., 1]), (after[..., 0], after[..., 1]), (part[..., 0], part[..., 1])
