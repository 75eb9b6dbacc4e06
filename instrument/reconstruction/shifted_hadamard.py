r"""The measurement matrix of a moved object, which is never built.

A pattern P seen by an object that moved by d is the pattern u -> P(u + d) on the object at rest. A Hadamard pattern is the outer
product of two Walsh rows, and so is a shifted one: row k of the matrix is the outer product of two shifted Walsh rows Y[k] (down)
and X[k] (across). The matrix A is their row-wise Khatri-Rao product, so that for an image U and values v

    A U = rowsum((Y U) * X),    A' v = Y' diag(v) X.

Of each pattern's two Walsh rows, the one with fewer sign changes is applied through these (``RowProducts``). Where both change
sign often, the sum over pixels as it stands above is quicker (``DenseProducts``): which is chosen hangs on their numbers alone.

References:
    C. G. Khatri, C. R. Rao, "Solutions to some functional equations and their applications to characterization of
    probability distributions", Sankhya A 30 (1968) 167-180.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final, Self

import numpy as np

from instrument.numerics import DenseProducts, RowProducts, side_by_side
from instrument.reconstruction.field import Field
from instrument.reconstruction.region import Region
from instrument.reconstruction.walsh_rows import walsh_changes, walsh_rows
from protocols import Floats, Integers, Mask, Singles

_SAME_PLACE_PX = 0.05

_OFTEN: Final = 0.17
"""Sign changes over image pixels a side, along the axis where a pattern has fewer, from which on a matrix product is quicker: a
sum through a change takes three times as long as one through a pixel, and there are two to a change."""

_FEWEST_DENSE: Final = 1024
"""Patterns that it must be for, else they are no faster for it."""

_LARGE: Final = 1 << 20
"""Patterns times pixels a side from which on the parts of a product go to several cores: below, they cost more than they save."""


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

    def only(self, chosen: Mask | Integers) -> "_Factor":
        """Give the rows of the chosen patterns."""
        return _Factor(self.field, self.walsh[chosen], self.place_px[chosen], self.first_px, self.count_px)

    def times(self, many: "_Factor") -> RowProducts:
        """Prepare the products of patterns whose other factor, ``many``, has at least as many sign changes."""
        few = walsh_changes(self.field, self.walsh, self.place_px, self.first_px, self.count_px)
        return RowProducts.of(few, many.written_out())

    def written_out(self) -> Singles:
        """Give the rows as an array."""
        return walsh_rows(self.field, self.walsh, self.place_px, self.first_px, self.count_px)


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
    """Patterns with at most as many sign changes down as across, and few."""

    _few_across: RowProducts
    """Those with fewer across, for the transposed image."""

    _dense: tuple[DenseProducts, ...]
    """Patterns with many of both, in two halves."""

    _of: tuple[Integers, ...]
    """Which of the ``terms * rows`` patterns belong to each of these, in order."""

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
        few = np.minimum(down.walsh, across.walsh) < _OFTEN * field.pixels
        if np.count_nonzero(~few) < _FEWEST_DENSE:
            few[:] = True
        few_down, few_across = few & (down.walsh <= across.walsh), few & (down.walsh > across.walsh)
        halves = [half for half in np.array_split(np.flatnonzero(~few), 2) if len(half)]
        return cls(
            coefficients=np.array(coefficients, np.float32),
            rows=len(pairs) // len(coefficients),
            image_shape=(region.height * field.grid, region.width * field.grid),
            _few_down=down.only(few_down).times(across.only(few_down)),
            _few_across=across.only(few_across).times(down.only(few_across)),
            _dense=tuple(
                DenseProducts(down.only(half).written_out(), across.only(half).written_out()) for half in halves
            ),
            _of=(np.flatnonzero(few_down), np.flatnonzero(few_across), *halves),
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
        itself, shifted: the change of total light of an object that crosses the field's edge. That part is left out where a
        ``region`` stays inside, but for parts of a pixel. Where d+ and d- are nowhere more than 0.05 px apart, their mean
        stands for both.

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
        if (
            region is not None
            and region != Region.whole(field.size)
            and region.stays(both_px.reshape(-1, 2), field.size)
        ):
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
        few = self._few_down.nbytes + self._few_across.nbytes
        return few + sum(dense.nbytes for dense in self._dense) + sum(rows.nbytes for rows in self._of)

    @property
    def dense_patterns(self) -> int:
        """Number of patterns whose products are matrix products."""
        return sum(len(dense.down) for dense in self._dense)

    def matvec(self, image: Singles) -> Singles:
        """Give the values of an image: ``(pixels,)`` to ``(rows,)``."""
        image = image.reshape(self.image_shape)
        found = self._together(
            [
                partial(self._few_down.forward, image),
                partial(self._few_across.forward, image.T),
                *(partial(dense.forward, image) for dense in self._dense),
            ]
        )
        values = np.empty(sum(map(len, self._of)), np.float32)
        for own, part in zip(self._of, found, strict=True):
            values[own] = part
        return self.coefficients @ values.reshape(len(self.coefficients), self.rows)

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        terms = np.outer(self.coefficients, values).ravel()
        height, width = self.image_shape
        down, across, *dense = self._together(
            [
                partial(self._few_down.backward, terms[self._of[0]], width),
                partial(self._few_across.backward, terms[self._of[1]], height),
                *(partial(part.backward, terms[own]) for part, own in zip(self._dense, self._of[2:], strict=True)),
            ]
        )
        image = down + across.T
        for part in dense:
            image += part
        return image.ravel()

    def _together(self, parts: Sequence[Callable[[], Singles]]) -> list[Singles]:
        """Compute the parts of a product, on several cores where it is large."""
        if self.rows * max(self.image_shape) < _LARGE:
            return [part() for part in parts]
        return side_by_side(parts)
