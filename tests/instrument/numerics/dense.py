"""Linear maps written down as matrices, of which everything can be computed by plain algebra."""

from dataclasses import dataclass

import numpy as np

from protocols import Floats, Singles


@dataclass(frozen=True, eq=False)
class Dense:
    """A matrix as an operator on images of this shape."""

    matrix: Floats
    image_shape: tuple[int, int]

    @property
    def image_shapes(self) -> tuple[tuple[int, int]]:
        """Height and width of the one image."""
        return (self.image_shape,)

    @property
    def shape(self) -> tuple[int, int]:
        rows, columns = self.matrix.shape
        return rows, columns

    def matvec(self, image: Singles) -> Singles:
        return np.asarray(self.matrix @ image, np.float32)

    def rmatvec(self, values: Singles) -> Singles:
        return np.asarray(self.matrix.T @ values, np.float32)
