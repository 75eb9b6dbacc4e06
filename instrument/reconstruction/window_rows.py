"""What is in the field in each frame: its total light, and the values of the patterns that measure position, as rows.

Where an object passes by, its parts come into the field one after the other. Those that come late are seen by the fine Hadamard
patterns alone, as coarse ones are shown first: how bright they are as a whole, no difference I_H+ - I_H- says. But every frame
measures the total light of what is in the field, and its share in coarse fringes.

The value of pattern P on an image O displaced by d is the correlation sum O(u) P(u + d), linear along each axis between whole
pixels, as in ``correlation``. Here it is worked out along one axis by Fourier transforms, and directly for the few whole
displacements that there are along the other: an object passes by on a line.
"""

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.sparse import csr_array

from instrument.reconstruction.field import Field
from instrument.reconstruction.region import Region
from protocols import Floats, InputError, Integers, Singles

_MOST_BYTES: Final = 400_000_000
"""Of the patterns' spectra at most: three times as much is needed while they are made."""


@dataclass(frozen=True, eq=False)
class WindowRows:
    """Whitened rows, frame by frame: the light through the first pattern, and through each of the others less half of that."""

    spectra: NDArray[np.complex64]
    """``(frequencies, n shifts, side)``: Fourier transforms of the n patterns along the way, at each whole shift across it."""

    sampling: csr_array
    """``(frames n, n shifts length)``: takes correlations to values."""

    sigma: Singles
    """``(frames, n)``: noise of each row's value."""

    image_shape: tuple[int, int]
    """Height and width of the image, in image pixels."""

    down: bool
    """Whether the way leads along y."""

    length: int
    """Places along the way, negative displacements counted from the end."""

    @classmethod
    def of(cls, patterns: Singles, places_px: Floats, sigma: Floats, field: Field, region: Region) -> Self:
        """Prepare the rows of a run.

        Args:
            patterns: ``(n, pixels, pixels)`` as they act, such as ``field.acting`` gives; the first lets all light through.
            places_px: ``(frames, n, 2)`` displacement of the object, x and y, during each.
            sigma: ``(frames, n)`` standard deviation of each row's value.
            field: field, and the grid of the image.
            region: pattern pixels of the image.
        """
        grid, pixels = field.grid, field.pixels
        shape = (region.height * grid, region.width * grid)
        corner = (places_px + np.array([region.left, region.top], np.float64)) * grid
        corner = np.clip(corner, [-shape[1], -shape[0]], pixels - 1e-6)  # from there on the object is outside the field
        down = bool(np.ptp(corner[..., 1]) > np.ptp(corner[..., 0]))
        along, across = corner[..., int(down)], corner[..., 1 - int(down)]
        side, reach = (shape[1], shape[0]) if down else shape
        turned = patterns.transpose(0, 2, 1) if down else patterns
        first, last = int(np.floor(across.min())), int(np.floor(across.max())) + 1
        length = int(fft.next_fast_len(pixels + reach, real=True))
        if 8 * (length // 2 + 1) * len(patterns) * (last + 1 - first) * side > _MOST_BYTES:
            raise InputError(
                saw=f"an object that passes by across {last - first} rows or columns of the image as well as along them",
                expected="a path that leads nearly along rows or along columns",
                remedy="turn the stage's axis to the modulator's, or take the grid 1, or fewer pixels",
            )
        spectra: NDArray[np.complex64] = fft.rfft(turned, length, axis=2)
        rows = np.add.outer(
            np.arange(first, last + 1), np.arange(side)
        )  # row of the pattern that a row of the image is seen by
        seen = spectra[:, np.clip(rows, 0, pixels - 1)] * ((rows >= 0) & (rows < pixels))[..., None]
        by_frequency = np.ascontiguousarray(
            seen.reshape(-1, side, seen.shape[-1]).transpose(2, 0, 1).astype(np.complex64)
        )
        sampling = _sampling(along, across - first, last + 1 - first, length)
        return cls(by_frequency, sampling, sigma.astype(np.float32), shape, down, length)

    @property
    def columns(self) -> int:
        """Number of rows to a frame."""
        return int(self.sigma.shape[1])

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of pixels."""
        return self.sigma.size, self.image_shape[0] * self.image_shape[1]

    @property
    def image_shapes(self) -> tuple[tuple[int, int]]:
        """Height and width of the one unknown image, in image pixels."""
        return (self.image_shape,)

    def matvec(self, image: Singles) -> Singles:
        """Give the values of an image: ``(pixels,)`` to ``(rows,)``."""
        pixels = image.reshape(self.image_shape)
        seen: NDArray[np.complex64] = fft.rfft(pixels.T if self.down else pixels, self.length, axis=1)
        maps: Singles = fft.irfft((self.spectra @ np.conj(seen.T)[..., None])[..., 0].T, self.length, axis=1)
        values = (self.sampling @ maps.ravel()).reshape(self.sigma.shape)
        values[:, 1:] -= values[:, :1] / 2
        return np.asarray(values / self.sigma, np.float32).ravel()

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        seen = values.reshape(self.sigma.shape) / self.sigma
        seen[:, 0] -= seen[:, 1:].sum(axis=1) / 2
        maps = np.asarray(self.sampling.T @ seen.ravel(), np.float32).reshape(-1, self.length)
        spectrum: NDArray[np.complex64] = np.conj(fft.rfft(maps, axis=1))
        together: NDArray[np.complex64] = (spectrum.T[:, None] @ self.spectra)[:, 0].T
        image: Singles = fft.irfft(together, self.length, axis=1)
        height, width = self.image_shape
        return (image[:, :height].T if self.down else image[:, :width]).ravel()


def _sampling(along: Floats, across: Floats, shifts: int, length: int) -> csr_array:
    """Give the matrix that reads correlations, ``(n, shifts, length)``, at places, ``(frames, n)``, by linear interpolation."""
    count = int(along.shape[1])
    whole, row = np.floor(along).astype(np.int64), np.floor(across).astype(np.int64)
    part, part_across = along - whole, across - row
    first: Integers = (np.arange(count) * shifts + row) * length
    columns = [first + down * length + (whole + on) % length for down in (0, 1) for on in (0, 1)]
    weights = [
        (part_across if down else 1 - part_across) * (part if on else 1 - part) for down in (0, 1) for on in (0, 1)
    ]
    entries = np.stack(weights).astype(np.float32).ravel()
    rows = np.tile(np.arange(along.size), 4)
    return csr_array((entries, (rows, np.stack(columns).ravel())), shape=(along.size, count * shifts * length))
