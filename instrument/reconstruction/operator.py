r"""The measurement matrix of a moved object, never built.

A pattern seen by an object that moved by d is the pattern moved by -d over the object at rest. A Hadamard pattern is the
outer product of two Walsh rows, and so is a shifted one: row k of the matrix is the outer product of two shifted Walsh rows
L_y[k], L_x[k], and the matrix is their row-wise Khatri-Rao product. Hence

    A x = rowsum((L_y X) * L_x),    A' v = L_y' diag(v) L_x,    A A' = (L_y L_y') * (L_x L_x').

An object of square pixels moved by a fraction of a pixel covers the pattern's pixels in proportion: linear interpolation of
the Walsh rows is exact, and separable.

References:
    C. G. Khatri, C. R. Rao, "Solutions to some functional equations and their applications to characterization of
    probability distributions", Sankhya A 30 (1968) 167-180.
"""

from dataclasses import dataclass
from typing import Protocol, Self, TypeAlias

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from instrument.patterns import walsh_matrix
from instrument.reconstruction.region import Region
from protocols import Floats, Integers

Singles: TypeAlias = NDArray[np.float32]
"""Real numbers in single precision: relative rounding 6e-8, far below any measured noise."""

_SAME_PLACE_PX = 0.05


class Operator(Protocol):
    """What a solver knows of the measurement: a linear map from an image to values, and its transpose."""

    @property
    def shape(self) -> tuple[int, int]:
        """Rows (values) and columns (pixels)."""
        ...

    @property
    def image_shape(self) -> tuple[int, int]:
        """Height and width of the image whose pixels, row by row, are the columns."""
        ...

    def matvec(self, image: Singles) -> Singles:
        """``(pixels,)`` to ``(rows,)``."""
        ...

    def rmatvec(self, values: Singles) -> Singles:
        """``(rows,)`` to ``(pixels,)``."""
        ...


@dataclass(frozen=True, eq=False)
class ShiftedHadamard:
    """Rows that are sums of few outer products: one where both patterns of a pair stand at the same place, else more."""

    down: Singles
    """``(terms, rows, height)``: factors along y."""

    across: Singles
    """``(terms, rows, width)``: factors along x."""

    @classmethod
    def single(cls, pairs: Integers, displacement_px: Floats, size: int, region: Region | None = None) -> Self:
        """Rows H_k(x + d_k), zero outside the field.

        Args:
            pairs: ``(rows, 2)`` Walsh rows (c_i down, c_j across), as from ``hadamard_order``.
            displacement_px: ``(rows, 2)`` x, y of the object.
            size: pixels a side of the field.
            region: pixels of the image at rest that are unknown; None for the whole field.
        """
        down, across = walsh_factors(pairs, displacement_px, size, region)
        return cls(down[None], across[None])

    @classmethod
    def differential(
        cls, pairs: Integers, positive_px: Floats, negative_px: Floats, size: int, region: Region | None = None
    ) -> Self:
        """Rows of the value I_H+ - I_H-, each pattern at its own place of the object.

        H+ = (1 + H)/2 at d+ and H- = (1 - H)/2 at d- give (H(d+) + H(d-))/2 + (1(d+) - 1(d-))/2, where 1(d) is the field
        itself, shifted: the change of total light of an object that crosses the field's edge. That part is left out where
        a ``region`` keeps the object inside. Where d+ and d- are nowhere more than 0.05 px apart their mean stands for both.

        Args:
            pairs: ``(rows, 2)`` Walsh rows.
            positive_px: ``(rows, 2)`` displacement while H+ is shown.
            negative_px: ``(rows, 2)`` displacement while H- is shown.
            size: pixels a side of the field.
            region: as in ``single``.
        """
        if len(pairs) == 0 or np.abs(positive_px - negative_px).max() <= _SAME_PLACE_PX:
            return cls.single(pairs, (positive_px + negative_px) / 2, size, region)
        factors = [walsh_factors(pairs, place, size, region) for place in (positive_px, negative_px)]
        signs = [0.5, 0.5]
        if region is None or region == Region.whole(size):
            field = np.zeros_like(pairs)
            factors += [walsh_factors(field, place, size, region) for place in (positive_px, negative_px)]
            signs += [0.5, -0.5]
        down = np.stack([np.float32(sign) * factor[0] for sign, factor in zip(signs, factors, strict=True)])
        return cls(down, np.stack([factor[1] for factor in factors]))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and pixels."""
        return self.down.shape[1], self.down.shape[2] * self.across.shape[2]

    @property
    def image_shape(self) -> tuple[int, int]:
        """Height and width of the unknown image."""
        return self.down.shape[2], self.across.shape[2]

    @property
    def nbytes(self) -> int:
        """Memory of the operator."""
        return self.down.nbytes + self.across.nbytes

    def matvec(self, image: Singles) -> Singles:
        """Values of an image: ``(pixels,)`` to ``(rows,)``."""
        height, _ = self.image_shape
        columns = self.down.reshape(-1, height) @ image.reshape(self.image_shape)
        values: Singles = np.einsum("trw,trw->r", columns.reshape(self.across.shape), self.across)
        return values

    def rmatvec(self, values: Singles) -> Singles:
        """The transpose: ``(rows,)`` to ``(pixels,)``."""
        height, width = self.image_shape
        scaled: Singles = values[:, None] * self.across
        image: Singles = self.down.reshape(-1, height).T @ scaled.reshape(-1, width)
        return image.ravel()

    def gram(self) -> Singles:
        """A A', ``(rows, rows)``."""
        rows, terms = self.shape[0], range(len(self.down))
        gram = np.zeros((rows, rows), np.float32)
        for s in terms:
            for t in terms:
                gram += (self.down[s] @ self.down[t].T) * (self.across[s] @ self.across[t].T)
        return gram


@dataclass(frozen=True, eq=False)
class Weighted:
    """The rows of another operator, each multiplied by its weight."""

    operator: Operator
    """Whose rows."""

    weight: Singles
    """``(rows,)``."""

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and pixels."""
        return self.operator.shape

    @property
    def image_shape(self) -> tuple[int, int]:
        """Height and width of the unknown image."""
        return self.operator.image_shape

    def matvec(self, image: Singles) -> Singles:
        """Weighted values of an image."""
        return self.weight * self.operator.matvec(image)

    def rmatvec(self, values: Singles) -> Singles:
        """The transpose."""
        return self.operator.rmatvec(self.weight * values)


def largest_eigenvalue(operator: Operator, iterations: int = 20) -> float:
    """Estimate the largest eigenvalue of A'A from below, by the power method from a random image."""
    image = np.random.default_rng(0).random(operator.shape[1]).astype(np.float32)
    value = 0.0
    for _ in range(iterations):
        image /= max(float(np.linalg.norm(image)), 1e-30)
        image = operator.rmatvec(operator.matvec(image))
        value = float(np.linalg.norm(image))
    return value


def walsh_factors(
    pairs: Integers, displacement_px: Floats, size: int, region: Region | None = None, *, slope: bool = False
) -> tuple[Singles, Singles]:
    """Shift Walsh rows by fractions of a pixel, zero outside the field: entry u of a row is w(u + d).

    Args:
        pairs: ``(rows, 2)`` Walsh rows (c_i down, c_j across).
        displacement_px: ``(rows, 2)`` x, y.
        size: pixels a side of the field.
        region: pixels wanted; None for the whole field.
        slope: give the derivative by d instead of the row.

    Returns:
        ``(rows, height)`` along y and ``(rows, width)`` along x.
    """
    region = region or Region.whole(size)
    padding = size + 1
    walsh = np.pad(walsh_matrix(size).astype(np.float32), ((0, 0), (padding, padding)))

    def shifted(rows: Integers, place_px: Floats, first: int, count: int) -> Singles:
        whole = np.floor(place_px)
        fraction = (place_px - whole).astype(np.float32)[:, None]
        start = np.clip(whole.astype(np.int64) + first + padding, 0, size + 2 * padding - count - 1)
        window = sliding_window_view(walsh, count + 1, axis=1)[rows, start]
        near, far = window[:, :-1], window[:, 1:]
        return far - near if slope else near + fraction * (far - near)

    return (
        shifted(pairs[:, 0], displacement_px[:, 1], region.top, region.height),
        shifted(pairs[:, 1], displacement_px[:, 0], region.left, region.width),
    )
