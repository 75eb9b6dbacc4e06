"""The measurement matrix written out, for solvers that know no structure."""

from dataclasses import dataclass

import numpy as np

from protocols import Floats, Singles


@dataclass(frozen=True, eq=False)
class DenseSingles:
    """A matrix with the contract of an operator: in double precision inside, in single precision to a solver."""

    matrix: Floats
    """``(rows, pixels)``."""

    image_shape: tuple[int, int]
    """Height and width."""

    @property
    def image_shapes(self) -> tuple[tuple[int, int]]:
        """Height and width of the one image."""
        return (self.image_shape,)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and pixels."""
        return self.matrix.shape[0], self.matrix.shape[1]

    def matvec(self, image: Singles) -> Singles:
        """Multiply ``(pixels,)`` to ``(rows,)``."""
        values: Singles = (self.matrix @ image).astype(np.float32)
        return values

    def rmatvec(self, values: Singles) -> Singles:
        """Multiply the transpose: ``(rows,)`` to ``(pixels,)``."""
        image: Singles = (self.matrix.T @ values).astype(np.float32)
        return image
