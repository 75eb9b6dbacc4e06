"""The measurement matrix written out, row by row: the oracle for structured operators."""

from dataclasses import dataclass

import numpy as np

from instrument.patterns import hadamard_signs
from protocols import Floats, Integers, Singles
from tests.support.simulation import shifted


@dataclass(frozen=True, eq=False)
class Dense:
    """A matrix with the contract of an operator."""

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

    def matvec(self, image: Floats) -> Floats:
        """``(pixels,)`` to ``(rows,)``."""
        return self.matrix @ image

    def rmatvec(self, values: Floats) -> Floats:
        """``(rows,)`` to ``(pixels,)``."""
        return self.matrix.T @ values


@dataclass(frozen=True, eq=False)
class DenseSingles:
    """The same in double precision inside, and in single precision to a solver."""

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
        """``(pixels,)`` to ``(rows,)``."""
        values: Singles = (self.matrix @ image).astype(np.float32)
        return values

    def rmatvec(self, values: Singles) -> Singles:
        """``(rows,)`` to ``(pixels,)``."""
        image: Singles = (self.matrix.T @ values).astype(np.float32)
        return image


def seen_patterns(patterns: Floats, displacement_px: Floats) -> Floats:
    """``(rows, size, size)`` patterns as an object displaced by ``(rows, 2)`` sees them: moved by -d, zero from outside."""
    return np.stack([shifted(p, -dx, -dy) for p, (dx, dy) in zip(patterns, displacement_px, strict=True)])


def dense_differential(pairs: Integers, positive_px: Floats, negative_px: Floats, size: int) -> Dense:
    """Rows of I_H+ - I_H-, each pattern at its own place."""
    signs = hadamard_signs(size, pairs).astype(np.float64)
    rows = seen_patterns((1 + signs) / 2, positive_px) - seen_patterns((1 - signs) / 2, negative_px)
    return Dense(rows.reshape(len(pairs), -1), (size, size))
