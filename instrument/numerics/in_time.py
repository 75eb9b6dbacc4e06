"""Rows that change slowly from one to the next, as cosine series over time, none of which weighs more than it should.

A pattern that is shown in every frame to an object that moves says nearly the same each time: as rows of an image problem such
values would be known so precisely together that a first-order solver could not converge. A series of cosines over time keeps all
that they say. The terms that are slow in time hold what is known best: their weight is lowered to that of other rows.
"""

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from scipy import fft

from instrument.numerics.operators import Operator
from protocols import Floats, Singles

_PROBES: Final = 16
"""White images from which the length of every row is found, to a fifth or so."""

_LEAST: Final = 0.5
"""Length of a row from which on it says more of an image than its noise hides."""


@dataclass(frozen=True, eq=False)
class InTime:
    """Cosine terms over time of whitened rows of another operator, which stand time by time, with as many columns each time."""

    operator: Operator
    """``(times columns)`` rows."""

    weight: Singles
    """``(terms, columns)``: weight of each term, 1 or less."""

    @classmethod
    def of(cls, operator: Operator, columns: int, longest: float, *, steady: bool = True) -> Self:
        """Prepare the terms of a whitened operator.

        Args:
            operator: its rows are time by time, ``columns`` to each.
            columns: number of values of each time.
            longest: Euclidean length that a row is given at most.
            steady: whether the mean over time is a term too.
        """
        times = operator.shape[0] // columns
        rng, power = np.random.default_rng(0), np.zeros((times, columns))
        for _ in range(_PROBES):
            seen = operator.matvec(rng.standard_normal(operator.shape[1]).astype(np.float32))
            power += _terms(seen.reshape(times, columns)) ** 2 / _PROBES
        length: Floats = np.sqrt(power)
        known = np.flatnonzero((length > _LEAST).any(axis=1))
        used = int(known[-1]) + 1 if len(known) else 0
        weight = np.minimum(1.0, longest / np.maximum(length[:used], 1e-30))
        weight[: 0 if steady else 1] = 0.0
        return cls(operator, weight.astype(np.float32))

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of pixels."""
        return self.weight.size, self.operator.shape[1]

    @property
    def image_shapes(self) -> tuple[tuple[int, int], ...]:
        """Height and width of each unknown image, in pixels."""
        return self.operator.image_shapes

    def matvec(self, image: Singles) -> Singles:
        """Give the values of an image: ``(pixels,)`` to ``(rows,)``."""
        return self.terms(self.operator.matvec(image))

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        terms, columns = self.weight.shape
        padded = np.zeros((self.operator.shape[0] // columns, columns), np.float32)
        padded[:terms] = values.reshape(terms, columns) * self.weight
        return self.operator.rmatvec(np.asarray(fft.idct(padded, axis=0, norm="ortho"), np.float32).ravel())

    def terms(self, values: Singles) -> Singles:
        """Give the weighted terms, ``(rows,)``, of whitened values, ``(times columns,)``."""
        terms, columns = self.weight.shape
        return (_terms(values.reshape(-1, columns))[:terms] * self.weight).astype(np.float32).ravel()


def _terms(series: Singles) -> Singles:
    return np.asarray(fft.dct(series, axis=0, norm="ortho"), np.float32)
