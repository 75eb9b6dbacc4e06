"""The measurement matrix of something that stands still, which is never built."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from instrument.reconstruction.field import Field, acting_walsh
from protocols import Integers, Singles


@dataclass(frozen=True, eq=False)
class StillHadamard:
    """Rows that are Hadamard patterns at rest: each value is entry (c_i, c_j) of the image's Walsh transform W U W'."""

    pairs: Integers
    """``(rows, 2)``: Walsh rows (c_i down, c_j across) of each pattern."""

    walsh: Singles
    """``(n, size)``: the Walsh rows as they act, up to the last one that is needed."""

    @classmethod
    def of(cls, pairs: Integers, field: Field) -> Self:
        """Prepare the rows of some patterns on the patterns' own grid."""
        needed = int(pairs.max(initial=0)) + 1
        return cls(pairs, acting_walsh(Field(field.size, 1, field.edge_loss))[:needed].astype(np.float32))

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of pixels."""
        return len(self.pairs), self.walsh.shape[1] ** 2

    @property
    def image_shapes(self) -> tuple[tuple[int, int]]:
        """Height and width of the one unknown image, in pixels."""
        return ((self.walsh.shape[1], self.walsh.shape[1]),)

    def matvec(self, image: Singles) -> Singles:
        """Give the values of an image: ``(pixels,)`` to ``(rows,)``."""
        transform = self.walsh @ image.reshape(self.image_shapes[0]) @ self.walsh.T
        return np.asarray(transform[self.pairs[:, 0], self.pairs[:, 1]], np.float32)

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        count = len(self.walsh)
        flat = self.pairs[:, 0] * count + self.pairs[:, 1]
        transform = np.bincount(flat, weights=values, minlength=count**2).astype(np.float32).reshape(count, count)
        return np.asarray(self.walsh.T @ transform @ self.walsh, np.float32).ravel()
