r"""The measurement matrix of a moved object, which is never built.

A pattern P seen by an object that moved by d is the pattern u -> P(u + d) on the object at rest. A Hadamard pattern is the outer
product of two Walsh rows, and so is a shifted one: row k of the matrix is the outer product of two shifted Walsh rows Y[k] (down)
and X[k] (across). The matrix A is their row-wise Khatri-Rao product, so that for an image U and values v

    A U = rowsum((Y U) * X),    A' v = Y' diag(v) X.

Of each pattern's two Walsh rows, the one with fewer sign changes is applied through these (``RowProducts``).

References:
    C. G. Khatri, C. R. Rao, "Solutions to some functional equations and their applications to characterization of
    probability distributions", Sankhya A 30 (1968) 167-180.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from instrument.numerics import RowProducts
from instrument.reconstruction.field import Field
from instrument.reconstruction.region import Region
from instrument.reconstruction.walsh_rows import walsh_changes, walsh_rows
from protocols import Floats, Integers, Mask, Singles

_SAME_PLACE_PX = 0.05


@dataclass(frozen=True, eq=False)
class _Factor:
    """Shifted Walsh rows along one axis of the image, one for each pattern."""

    field: Field
    """Field and grid."""

    walsh: Integers
    """``(patterns,)``: index of the Walsh row, which is its number of sign changes."""

    place_px: Floats
    """``(patterns,)``: displacement along the axis."""

    first_px: int
    """First pattern pixel of the region along the axis."""

    count_px: int
    """Number of pattern pixels of the region along the axis."""

    def only(self, chosen: Mask) -> "_Factor":
        """Give the rows of the chosen patterns."""
        return _Factor(self.field, self.walsh[chosen], self.place_px[chosen], self.first_px, self.count_px)

    def times(self, many: "_Factor") -> RowProducts:
        """Prepare the products of patterns whose other factor, ``many``, has at least as many sign changes."""
        few = walsh_changes(self.field, self.walsh, self.place_px, self.first_px, self.count_px)
        return RowProducts.of(few, walsh_rows(many.field, many.walsh, many.place_px, many.first_px, many.count_px))


@dataclass(frozen=True, eq=False)
class ShiftedHadamard:
    """Rows that are weighted sums of shifted Hadamard patterns, all with the same number of terms.

    All patterns together stand in the order (terms, rows): the first term of every row, then the second of every row, and so on.
    """

    coefficients: Singles
    """``(terms,)``: weight of each term."""

    rows: int
    """Number of rows of the matrix."""

    image_shape: tuple[int, int]
    """Height and width of the unknown image, in image pixels."""

    _few_down: RowProducts
    """Patterns with at most as many sign changes down as across."""

    _few_across: RowProducts
    """The other patterns, for the transposed image."""

    _is_few_down: Mask
    """``(terms * rows,)``: which of both a pattern belongs to."""

    @classmethod
    def of(
        cls,
        coefficients: Sequence[float],
        pairs: Integers,
        places_px: Floats,
        field: Field,
        region: Region | None = None,
    ) -> Self:
        """Prepare rows that are the sum over terms of coefficient times H(u + d); H is 0 outside the field.

        Args:
            coefficients: ``(terms,)``.
            pairs: ``(terms, rows, 2)`` Walsh rows (c_i down, c_j across) of each H, as from ``hadamard_order``.
            places_px: ``(terms, rows, 2)`` displacement d of the object, x and y.
            field: field, and the grid of the image.
            region: pattern pixels of the image at rest that are unknown; None for the whole field.
        """
        region = region or Region.whole(field.size)
        pairs, places_px = pairs.reshape(-1, 2), places_px.reshape(-1, 2)
        down = _Factor(field, pairs[:, 0], places_px[:, 1], region.top, region.height)
        across = _Factor(field, pairs[:, 1], places_px[:, 0], region.left, region.width)
        few_down = down.walsh <= across.walsh
        return cls(
            coefficients=np.array(coefficients, np.float32),
            rows=len(pairs) // len(coefficients),
            image_shape=(region.height * field.grid, region.width * field.grid),
            _few_down=down.only(few_down).times(across.only(few_down)),
            _few_across=across.only(~few_down).times(down.only(~few_down)),
            _is_few_down=few_down,
        )

    @classmethod
    def single(cls, pairs: Integers, displacement_px: Floats, field: Field, region: Region | None = None) -> Self:
        """Prepare rows H_k(u + d_k): ``of`` with one term, and ``(rows, 2)`` pairs and displacements."""
        return cls.of([1.0], pairs, displacement_px, field, region)

    @classmethod
    def differential(
        cls, pairs: Integers, positive_px: Floats, negative_px: Floats, field: Field, region: Region | None = None
    ) -> Self:
        """Prepare rows of the value I_H+ - I_H-, each pattern at its own displacement of the object.

        H+ = (1 + H)/2 at d+ and H- = (1 - H)/2 at d- give (H(d+) + H(d-))/2 + (1(d+) - 1(d-))/2, where 1(d) is the field
        itself, shifted: the change of total light of an object that crosses the field's edge. That part is left out where
        a ``region`` keeps the object inside. Where d+ and d- are nowhere more than 0.05 px apart, their mean stands for both.

        Args:
            pairs: ``(rows, 2)`` Walsh rows.
            positive_px: ``(rows, 2)`` displacement while H+ is shown, x and y.
            negative_px: ``(rows, 2)`` displacement while H- is shown, x and y.
            field: field, and the grid of the image.
            region: as in ``of``.
        """
        if len(pairs) == 0 or np.abs(positive_px - negative_px).max() <= _SAME_PLACE_PX:
            return cls.single(pairs, (positive_px + negative_px) / 2, field, region)
        both_px = np.stack([positive_px, negative_px])
        if region is not None and region != Region.whole(field.size):
            return cls.of([0.5, 0.5], np.stack([pairs, pairs]), both_px, field, region)
        all_on = np.zeros_like(pairs)
        places_px = np.concatenate([both_px, both_px])
        return cls.of([0.5, 0.5, 0.5, -0.5], np.stack([pairs, pairs, all_on, all_on]), places_px, field, region)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of pixels."""
        height, width = self.image_shape
        return self.rows, height * width

    @property
    def image_shapes(self) -> tuple[tuple[int, int]]:
        """Height and width of the one unknown image, in image pixels."""
        return (self.image_shape,)

    @property
    def nbytes(self) -> int:
        """Memory of the operator, in bytes."""
        return self._few_down.nbytes + self._few_across.nbytes + self._is_few_down.nbytes

    def matvec(self, image: Singles) -> Singles:
        """Give the values of an image: ``(pixels,)`` to ``(rows,)``."""
        image = image.reshape(self.image_shape)
        values = np.empty(len(self._is_few_down), np.float32)
        values[self._is_few_down] = self._few_down.forward(image)
        values[~self._is_few_down] = self._few_across.forward(image.T)
        return self.coefficients @ values.reshape(len(self.coefficients), self.rows)

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        terms = np.outer(self.coefficients, values).ravel()
        height, width = self.image_shape
        image: Singles = self._few_down.backward(terms[self._is_few_down], width)
        image = image + self._few_across.backward(terms[~self._is_few_down], height).T
        return image.ravel()
