"""What fixed patterns see of an image, wherever it is: correlation maps."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from instrument.reconstruction.region import Region
from instrument.schemes import FourierHadamard
from protocols import Floats, Singles


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

    @classmethod
    def of(cls, scheme: FourierHadamard, region: Region) -> Self:
        """The binary Fourier patterns of a scheme, their dithering included."""
        size, finer = scheme.plan.image_size, scheme.plan.upsampling
        samples = scheme.fourier.reshape(-1, size, finer, size, finer)
        return cls(samples.mean(axis=(2, 4)).astype(np.float32), region)

    @property
    def _width(self) -> int:
        size: int = self.patterns.shape[-1]
        return 2 * size

    @cached_property
    def _spectra(self) -> NDArray[np.complex64]:
        spectra: NDArray[np.complex64] = fft.rfft2(self.patterns, (self._width, self._width))
        return spectra

    def maps(self, image: Singles) -> Singles:
        """``(n, 2 size, 2 size)``: C at whole displacements, negative ones counted from the end.

        Args:
            image: ``(height, width)`` of the region.
        """
        padded = np.zeros(self.patterns.shape[1:], np.float32)
        padded[self.region.top : self.region.top + self.region.height, self.region.left :][:, : self.region.width] = (
            image
        )
        seen = np.conj(fft.rfft2(padded, (self._width, self._width))) * self._spectra
        maps: Singles = fft.irfft2(seen, (self._width, self._width))
        return maps

    def values(self, maps: Singles, places_px: Floats) -> tuple[Floats, Floats]:
        """Read maps at displacements.

        Args:
            maps: of the image.
            places_px: ``(rows, n, 2)`` x, y: of each pattern in each row.

        Returns:
            ``(rows, n)`` values, and ``(rows, n, 2)`` their derivatives by x and y.
        """
        size = self.patterns.shape[-1]
        places = np.clip(places_px, -size, size - 1e-6)  # farther away there is nothing left to see
        whole = np.floor(places).astype(np.int64)
        part = places - whole
        pattern = np.arange(len(self.patterns))
        x, y = whole[..., 0], whole[..., 1]
        next_x, next_y = ((place + 1 + size) % (2 * size) - size for place in (x, y))
        near, right = maps[pattern, y, x], maps[pattern, y, next_x]
        down, both = maps[pattern, next_y, x], maps[pattern, next_y, next_x]
        across_px, down_px = part[..., 0], part[..., 1]
        upper, lower = near + across_px * (right - near), down + across_px * (both - down)
        slope_x = (1 - down_px) * (right - near) + down_px * (both - down)
        values: Floats = (upper + down_px * (lower - upper)).astype(np.float64)
        slopes: Floats = np.stack([slope_x, lower - upper], axis=-1).astype(np.float64)
        return values, slopes
