"""The modulator's field as the light sees it: Walsh rows on the image's grid, grey where mirrors lose light at their edges."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.sparse import csr_array

from instrument.patterns import walsh_matrix
from protocols import Bytes, Floats, Integers, Singles


@dataclass(frozen=True)
class Field:
    """A square field of pattern pixels, and the pixels that an image of it has.

    A displaced object is seen through patterns at fractions of a pixel, so that an image can have smaller pixels than the
    patterns have. Its pixels are 1 / ``grid`` of a pattern pixel wide; lengths in px are those of pattern pixels all the same.
    """

    size: int
    """Pattern pixels a side."""

    grid: int = 1
    """Image pixels that a pattern pixel has along each axis."""

    edge_loss: float = 0.0
    """Share of a lit pattern pixel's light that is lost for each of its four sides that borders a dark one."""

    @property
    def pixels(self) -> int:
        """Image pixels a side."""
        return self.size * self.grid

    def acting(self, patterns: Bytes) -> Singles:
        """Give the transmission of binary patterns as they act, on the image's grid.

        A lit sample loses its share of light at each side that borders a dark one; what lies outside the field is dark. Samples
        smaller than a pattern pixel have as many mirrors along a side as they are wide, so that their share is larger.

        Args:
            patterns: ``(n, samples, samples)`` of 0 and 1; samples is a multiple of ``size``.

        Returns:
            ``(n, pixels, pixels)``: the light of each image pixel for a transmission of 1, in units of a pattern pixel's light.
        """
        lit = self._on_grid(patterns.astype(np.float32))
        if self.edge_loss == 0:
            return lit
        return np.asarray(lit - self.edge_loss * self.bordering(patterns), np.float32)

    def bordering(self, patterns: Bytes) -> Singles:
        """Give the light that binary patterns lose for an edge loss of 1, on the image's grid; see ``acting``."""
        around = np.pad(patterns, ((0, 0), (1, 1), (1, 1)))
        sides = around[:, :-2, 1:-1] + around[:, 2:, 1:-1] + around[:, 1:-1, :-2] + around[:, 1:-1, 2:]
        return self._on_grid((patterns * (4 - sides)).astype(np.float32) * np.float32(patterns.shape[-1] / self.size))

    def _on_grid(self, samples: Singles) -> Singles:
        """Give ``(n, samples, samples)`` transmissions as light of the image's pixels, ``(n, pixels, pixels)``."""
        count, side = len(samples), samples.shape[-1]
        both = int(np.gcd(side, self.pixels))  # the finest grid whose pixels are whole on either
        means = samples.reshape(count, both, side // both, both, side // both).mean(axis=(2, 4))
        finer = self.pixels // both
        return np.asarray(means.repeat(finer, axis=1).repeat(finer, axis=2) / self.grid**2, np.float32)


@lru_cache(maxsize=8)
def acting_walsh(field: Field) -> Floats:
    """Give the Walsh rows as they act, ``(size, pixels)``: the weight of each image pixel along one axis.

    With n sides of a pixel along the axis that border the opposite sign or the outside of the field, an entry is +-(1 - n times
    ``edge_loss``). The difference of a Hadamard pattern and its complement is the outer product of two such rows, but for the
    square of the loss in corners. The array is kept and read-only.
    """
    walsh = walsh_matrix(field.size).astype(np.float64)
    around = np.pad(walsh, ((0, 0), (1, 1)))
    bordering = (around[:, :-2] != walsh).astype(np.float64) + (around[:, 2:] != walsh)
    coarse = walsh * (1 - field.edge_loss * bordering)
    rows = np.asarray(coarse.repeat(field.grid, axis=1) / field.grid, np.float64)
    rows.flags.writeable = False
    return rows


@lru_cache(maxsize=8)
def padded_walsh(field: Field, outside: int | None = None) -> Singles:
    """Give the acting Walsh rows, ``(size, pixels + 2 outside)``, with so many zeros on both sides; None is pixels + 1."""
    outside = field.pixels + 1 if outside is None else outside
    return np.pad(acting_walsh(field).astype(np.float32), ((0, 0), (outside, outside)))


@lru_cache(maxsize=8)
def walsh_steps(field: Field) -> csr_array:
    """Give the steps, ``(size, pixels + 1)``, of each acting Walsh row at positions 0 to ``pixels``: first from 0, last to 0."""
    return csr_array(np.diff(np.pad(acting_walsh(field), ((0, 0), (1, 1))), axis=1))


def hadamard_values(field: Field, image: Floats | Singles, pairs: Integers) -> Floats:
    """Give the differences I_H+ - I_H- of an image at rest.

    Args:
        field: field, and the grid of the image.
        image: ``(pixels, pixels)``.
        pairs: ``(rows, 2)`` Walsh rows of each pattern.

    Returns:
        ``(rows,)``.
    """
    rows = acting_walsh(field)
    return np.asarray((rows @ image @ rows.T)[pairs[:, 0], pairs[:, 1]], np.float64)
