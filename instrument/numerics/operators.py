"""Linear maps from images to values, and their transposes: all that a solver needs to know of a measurement."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from protocols import Singles


class Operator(Protocol):
    """A linear map from an image, or from several whose light adds, to values, and its transpose."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows (values) and of columns (pixels)."""
        ...

    @property
    def image_shapes(self) -> tuple[tuple[int, int], ...]:
        """Height and width, in pixels, of each image; their pixels, row by row and image after image, are the columns."""
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
    def image_shapes(self) -> tuple[tuple[int, int], ...]:
        """Height and width of each unknown image, in pixels."""
        return self.operator.image_shapes

    def matvec(self, image: Singles) -> Singles:
        """Give the weighted values of an image: ``(pixels,)`` to ``(rows,)``."""
        return self.weight * self.operator.matvec(image)

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        return self.operator.rmatvec(self.weight * values)


@dataclass(frozen=True, eq=False)
class Scaled:
    """The columns of another operator, each multiplied by its factor."""

    operator: Operator
    """The operator whose columns are multiplied."""

    factor: Singles
    """``(pixels,)``: factor of each column."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of pixels."""
        return self.operator.shape

    @property
    def image_shapes(self) -> tuple[tuple[int, int], ...]:
        """Height and width of each unknown image, in pixels."""
        return self.operator.image_shapes

    def matvec(self, image: Singles) -> Singles:
        """Give the values of an image: ``(pixels,)`` to ``(rows,)``."""
        return self.operator.matvec(self.factor * image)

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        return self.factor * self.operator.rmatvec(values)


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
    def image_shapes(self) -> tuple[tuple[int, int], ...]:
        """Height and width of each unknown image, in pixels."""
        return self.above.image_shapes

    def matvec(self, image: Singles) -> Singles:
        """Give the values of an image: ``(pixels,)`` to ``(rows,)``."""
        return np.concatenate([self.above.matvec(image), self.below.matvec(image)])

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        rows = self.above.shape[0]
        return self.above.rmatvec(values[:rows]) + self.below.rmatvec(values[rows:])


@dataclass(frozen=True, eq=False)
class Layered:
    """Values to which several images contribute, each through an operator of its own."""

    layers: tuple[Operator, ...]
    """Operators with the same number of rows."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows, and of the pixels of all images."""
        return self.layers[0].shape[0], sum(layer.shape[1] for layer in self.layers)

    @property
    def image_shapes(self) -> tuple[tuple[int, int], ...]:
        """Height and width of each unknown image, in pixels."""
        return tuple(shape for layer in self.layers for shape in layer.image_shapes)

    def matvec(self, image: Singles) -> Singles:
        """Give the values of all images: ``(pixels,)`` to ``(rows,)``."""
        ends = np.cumsum([layer.shape[1] for layer in self.layers])[:-1]
        values = np.zeros(self.shape[0], np.float32)
        for layer, part in zip(self.layers, np.split(image, ends), strict=True):
            values += layer.matvec(part)
        return values

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        return np.concatenate([layer.rmatvec(values) for layer in self.layers])


@dataclass(frozen=True)
class Unseen:
    """Rows that see nothing of an image."""

    rows: int
    """Number of rows."""

    image_shapes: tuple[tuple[int, int], ...]
    """Height and width of each image, in pixels."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of pixels."""
        return self.rows, sum(height * width for height, width in self.image_shapes)

    def matvec(self, image: Singles) -> Singles:
        """Give values of 0, ``(rows,)``."""
        del image
        return np.zeros(self.rows, np.float32)

    def rmatvec(self, values: Singles) -> Singles:
        """Give images of 0, ``(pixels,)``."""
        del values
        return np.zeros(self.shape[1], np.float32)


def largest_eigenvalue(operator: Operator, iterations: int = 20) -> float:
    """Estimate the largest eigenvalue of A'A from below, by the power method from a random image."""
    image = np.random.default_rng(0).random(operator.shape[1]).astype(np.float32)
    value = 0.0
    for _ in range(iterations):
        image /= max(float(np.linalg.norm(image)), 1e-30)
        image = operator.rmatvec(operator.matvec(image))
        value = float(np.linalg.norm(image))
    return value
