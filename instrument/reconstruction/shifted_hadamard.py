r"""The measurement matrix of a moved object, never built.

A pattern seen by an object that moved by d is the pattern moved by -d over the object at rest. A Hadamard pattern is the
outer product of two Walsh rows, and so is a shifted one: row k of the matrix is the outer product of two shifted Walsh rows
L_y[k], L_x[k], and the matrix is their row-wise Khatri-Rao product,

    A x = rowsum((L_y X) * L_x),    A' v = L_y' diag(v) L_x,

of which one factor is applied through its few sign changes.

References:
    C. G. Khatri, C. R. Rao, "Solutions to some functional equations and their applications to characterization of
    probability distributions", Sankhya A 30 (1968) 167-180.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from instrument.numerics import RowProducts
from instrument.reconstruction.region import Region
from instrument.reconstruction.walsh_rows import walsh_changes, walsh_rows
from protocols import Floats, Integers, Singles

_SAME_PLACE_PX = 0.05


@dataclass(frozen=True, eq=False)
class ShiftedHadamard:
    """Rows that are weighted sums of shifted patterns: one where both of a pair stand at the same place, else more."""

    scales: Singles
    """``(terms,)``: weight of each row's first, second, ... pattern."""

    rows: int
    """Rows of the matrix."""

    region: Region
    """Pixels that the image has."""

    _down: RowProducts
    """Patterns that change sign less often down than across."""

    _across: RowProducts
    """The others, for the transposed image."""

    _is_down: NDArray[np.bool_]
    """``(terms * rows,)``: to which of both a pattern belongs."""

    @classmethod
    def of(
        cls, scales: Sequence[float], pairs: Integers, places_px: Floats, size: int, region: Region | None = None
    ) -> Self:
        """Rows that are sums of ``scales`` times H(x + d), zero outside the field.

        Args:
            scales: of each term.
            pairs: ``(terms, rows, 2)`` Walsh rows (c_i down, c_j across), as from ``hadamard_order``.
            places_px: ``(terms, rows, 2)`` x, y of the object.
            size: pixels a side of the field.
            region: pixels of the image at rest that are unknown; None for the whole field.
        """
        region = region or Region.whole(size)
        pairs, places_px = pairs.reshape(-1, 2), places_px.reshape(-1, 2)
        is_down = pairs[:, 0] <= pairs[:, 1]
        (i, j), (x, y) = pairs[is_down].T, places_px[is_down].T
        down = RowProducts.of(
            walsh_changes(size, i, y, region.top, region.height), walsh_rows(size, j, x, region.left, region.width)
        )
        (i, j), (x, y) = pairs[~is_down].T, places_px[~is_down].T
        across = RowProducts.of(
            walsh_changes(size, j, x, region.left, region.width), walsh_rows(size, i, y, region.top, region.height)
        )
        return cls(np.array(scales, np.float32), len(pairs) // len(scales), region, down, across, is_down)

    @classmethod
    def single(cls, pairs: Integers, displacement_px: Floats, size: int, region: Region | None = None) -> Self:
        """Rows H_k(x + d_k): ``of`` with one term, ``(rows, 2)`` pairs and displacements."""
        return cls.of([1.0], pairs, displacement_px, size, region)

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
            region: as in ``of``.
        """
        if len(pairs) == 0 or np.abs(positive_px - negative_px).max() <= _SAME_PLACE_PX:
            return cls.single(pairs, (positive_px + negative_px) / 2, size, region)
        both_px = np.stack([positive_px, negative_px])
        if region is not None and region != Region.whole(size):
            return cls.of([0.5, 0.5], np.stack([pairs, pairs]), both_px, size, region)
        field = np.zeros_like(pairs)
        places_px = np.concatenate([both_px, both_px])
        return cls.of([0.5, 0.5, 0.5, -0.5], np.stack([pairs, pairs, field, field]), places_px, size, region)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and pixels."""
        return self.rows, self.region.height * self.region.width

    @property
    def image_shape(self) -> tuple[int, int]:
        """Height and width of the unknown image."""
        return self.region.shape

    @property
    def nbytes(self) -> int:
        """Memory of the operator."""
        return self._down.nbytes + self._across.nbytes + self._is_down.nbytes

    def matvec(self, image: Singles) -> Singles:
        """Values of an image: ``(pixels,)`` to ``(rows,)``."""
        image = image.reshape(self.image_shape)
        values = np.empty(len(self._is_down), np.float32)
        values[self._is_down] = self._down.forward(image)
        values[~self._is_down] = self._across.forward(image.T)
        return self.scales @ values.reshape(len(self.scales), self.rows)

    def rmatvec(self, values: Singles) -> Singles:
        """The transpose: ``(rows,)`` to ``(pixels,)``."""
        scaled = np.outer(self.scales, values).ravel()
        height, width = self.image_shape
        image: Singles = self._down.backward(scaled[self._is_down], width)
        image = image + self._across.backward(scaled[~self._is_down], height).T
        return image.ravel()
