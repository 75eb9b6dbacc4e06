"""Linear maps from an image to values, and their transposes: all that a solver needs to know of a measurement."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from protocols import Singles


class Operator(Protocol):
    """A linear map from an image to values, and its transpose."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows (values) and of columns (pixels)."""
        ...

    @property
    def image_shape(self) -> tuple[int, int]:
        """Height and width, in pixels, of the image whose pixels, row by row, are the columns."""
        ...

    def matvec(self, image: Singles) -> Singles:
        """Give the values of an image: ``(pixels,)`` to ``(rows,)``."""
        ...

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        ...


@dataclass(frozen=True, eq=False)
class Weighted:
    """The rows of another operator, each multiplied by its weight."""

    operator: Operator
    """The operator whose rows are weighted."""

    weight: Singles
    """``(rows,)``: weight of each row."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of pixels."""
        return self.operator.shape

    @property
    def image_shape(self) -> tuple[int, int]:
        """Height and width of the unknown image, in pixels."""
        return self.operator.image_shape

    def matvec(self, image: Singles) -> Singles:
        """Give the weighted values of an image: ``(pixels,)`` to ``(rows,)``."""
        return self.weight * self.operator.matvec(image)

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        return self.operator.rmatvec(self.weight * values)


@dataclass(frozen=True, eq=False)
class Stacked:
    """The rows of one operator, followed by those of another one on the same image."""

    above: Operator
    """Operator of the first rows."""

    below: Operator
    """Operator of the other rows."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of pixels."""
        return self.above.shape[0] + self.below.shape[0], self.above.shape[1]

    @property
    def image_shape(self) -> tuple[int, int]:
        """Height and width of the unknown image, in pixels."""
        return self.above.image_shape

    def matvec(self, image: Singles) -> Singles:
        """Give the values of an image: ``(pixels,)`` to ``(rows,)``."""
        return np.concatenate([self.above.matvec(image), self.below.matvec(image)])

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        rows = self.above.shape[0]
        return self.above.rmatvec(values[:rows]) + self.below.rmatvec(values[rows:])


def largest_eigenvalue(operator: Operator, iterations: int = 20) -> float:
    """Estimate the largest eigenvalue of A'A from below, by the power method from a random image."""
    image = np.random.default_rng(0).random(operator.shape[1]).astype(np.float32)
    value = 0.0
    for _ in range(iterations):
        image /= max(float(np.linalg.norm(image)), 1e-30)
        image = operator.rmatvec(operator.matvec(image))
        value = float(np.linalg.norm(image))
    return value
