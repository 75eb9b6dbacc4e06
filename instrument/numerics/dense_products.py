"""Products of patterns with an image as matrix products: for patterns that change sign often along both axes."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from protocols import Singles

_BLOCK: Final = 1024
"""Patterns of one product: what comes of it stays in the cache until it is used."""


@dataclass(frozen=True, eq=False)
class DenseProducts:
    """Products of the patterns down(u) across(v) with images ``(length, width)``, u counting rows and v columns."""

    down: Singles
    """``(patterns, length)``: the factor along u, as ``walsh_rows`` gives it."""

    across: Singles
    """``(patterns, width)``: the factor along v."""

    @property
    def nbytes(self) -> int:
        """Memory of the factors, in bytes."""
        return self.down.nbytes + self.across.nbytes

    def forward(self, image: Singles) -> Singles:
        """Give the values, ``(patterns,)``, of an image ``(length, width)``."""
        values = np.empty(len(self.down), np.float32)
        for first in range(0, len(values), _BLOCK):
            own = slice(first, first + _BLOCK)
            values[own] = np.vecdot(self.down[own] @ image, self.across[own])
        return values

    def backward(self, values: Singles) -> Singles:
        """Apply the transpose: ``(patterns,)`` to ``(length, width)``."""
        image = np.zeros((self.down.shape[1], self.across.shape[1]), np.float32)
        for first in range(0, len(values), _BLOCK):
            own = slice(first, first + _BLOCK)
            image += self.down[own].T @ (values[own, None] * self.across[own])
        return image
