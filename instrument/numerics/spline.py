"""The discrete smoothing spline of one order and one strength, in time proportional to its length.

It is the x that minimises sum w (z - x)^2 + strength * sum (p-th differences of x)^2. As statistics: z has independent noise of
variance v / w, and x is a p-fold integrated random walk; strength is v over the variance of its steps. The strongest smoothing
leaves a polynomial of degree p - 1.

It is solved as a least-squares problem, by rotations that take in one datum and one difference after the other. The normal
equations, which are quicker, lose all digits of a smooth series.

References:
    Whittaker, Proc. Edinburgh Math. Soc. 41 (1923) 63-75. Eilers, Analytical Chemistry 75 (2003) 3631-3636.
"""

from dataclasses import dataclass
from math import comb

import numpy as np

from instrument.numerics.compiled import compiled, inlined
from protocols import Floats, Integers


@dataclass(frozen=True, eq=False)
class Spline:
    """A smoothed series and what is known about its errors."""

    values: Floats
    """``(n,)``: the series, gaps filled."""

    order: int
    """p: which differences were kept small."""

    strength: float
    """How much they count."""

    cost: float
    """The minimum: of weighted squares and penalty."""

    weights: Floats
    """``(n,)``: of the data; 0 in gaps."""

    _factor: Floats
    """``(p + 1, n)``: Cholesky factor of W + strength D'D, lower band form."""

    @classmethod
    def through(cls, series: Floats, weights: Floats, order: int, strength: float) -> "Spline":
        """Fit to ``(n,)`` equidistant data with these weights, at least ``order`` of them above 0."""
        factor, values = np.empty((order + 1, len(series))), np.empty(len(series))
        taps = np.array([float((-1) ** (order - i) * comb(order, i)) for i in range(order + 1)])
        cost = _least_squares(series, weights, taps, strength, factor, values)
        return cls(values, order, strength, cost, weights, factor)

    @property
    def data(self) -> int:
        """How many data it was fitted to."""
        return int(np.count_nonzero(self.weights))

    @property
    def freedom(self) -> float:
        """Degrees of freedom: how many data it could pass through. By the modes' asymptotic form (free ends)."""
        size, count = len(self.values), self.data
        angle = np.maximum(np.arange(size) - (self.order - 1) / 2, 0.0) * np.pi / size
        angle[: self.order] = 0.0
        penalty = self.strength * size / count * (2 * np.sin(angle / 2)) ** (2 * self.order)
        return float((1 / (1 + penalty)).sum()) * count / size

    def log_likelihood(self, noise_variance: float) -> float:
        """Of order and strength, restricted to what says nothing of a polynomial; but for a constant of each order."""
        free = self.data - self.order
        spread = 2 * float(np.log(self._factor[0]).sum()) - (len(self.values) - self.order) * np.log(self.strength)
        return -(free * float(np.log(noise_variance)) + self.cost / noise_variance + float(spread)) / 2

    def variances_to_first(self, places: Integers) -> Floats:
        """Variance of the values at these places minus the first value, for noise of variance 1 at weight 1."""
        return _variances_to_first(self._factor, places)


@inlined
def _take(weight: float, row: Floats, known: Floats, size: Floats) -> float:
    """Take one more equation into a triangle of them by a square-root-free Givens rotation.

    Args:
        weight: of the equation.
        row: its coefficients and, last, its right side; overwritten.
        known: ``(n, n + 1)``: unit upper triangle, right sides in the last column.
        size: ``(n,)``: weight of each of its rows.

    Returns:
        The weighted square of what the triangle cannot fulfil.

    References:
        Gentleman, J. Inst. Math. Appl. 12 (1973) 329-336.
    """
    for k in range(len(size)):
        if weight == 0:
            break
        if row[k] != 0:
            own = row[k]
            share = 1 / (size[k] + weight * own * own)
            kept, taken = size[k] * share, weight * own * share
            size[k] += weight * own * own
            weight *= kept
            for j in range(k + 1, len(row)):
                old = row[j]
                row[j] = old - own * known[k, j]
                known[k, j] = kept * known[k, j] + taken * old
    left: float = weight * row[-1] ** 2
    return left


@compiled("f8(f8[::1], f8[::1], f8[::1], f8, f8[:, ::1], f8[::1])")
def _least_squares(  # noqa: PLR0917
    series: Floats, weights: Floats, taps: Floats, strength: float, factor: Floats, values: Floats
) -> float:
    """Minimise the sum of weights (z - x)^2 and strength (taps applied to x)^2.

    Writes the normal matrix's Cholesky factor (lower band form) and x, and returns the sum of weights (z - x)^2 and the penalty.
    """
    count, order = len(series), len(taps) - 1
    known, size, row = np.zeros((order + 1, order + 2)), np.zeros(order + 1), np.zeros(order + 2)
    cost = 0.0
    for i in range(count):
        if weights[i] > 0:
            row[:] = 0
            row[0], row[-1] = 1, series[i]
            cost += _take(weights[i], row, known, size)
        if i + order < count:
            row[:-1], row[-1] = taps, 0
            cost += _take(strength, row, known, size)
        root = np.sqrt(size[0])
        factor[0, i], values[i] = root, known[0, -1]
        for k in range(1, order + 1):
            factor[k, i] = root * known[0, k]
        for k in range(order):
            size[k], known[k, -1] = size[k + 1], known[k + 1, -1]
            for j in range(k + 1, order):
                known[k, j] = known[k + 1, j + 1]
            known[k, order] = 0
        size[order] = 0
        known[order] = 0
    for i in range(count - 2, -1, -1):
        for k in range(1, min(order, count - 1 - i) + 1):
            values[i] -= factor[k, i] / factor[0, i] * values[i + k]
    return cost


@compiled("f8[::1](f8[:, ::1], i8[::1])")
def _variances_to_first(factor: Floats, places: Integers) -> Floats:
    """Variances of x at these places minus x[0], where the normal matrix has this Cholesky factor L: |inverse(L) (e - e_0)|^2."""
    order, count = len(factor) - 1, factor.shape[1]
    variances = np.zeros(len(places))
    last = np.zeros(order + 1)  # newest first
    for n in range(len(places)):
        last[:] = 0
        for i in range(count if places[n] > 0 else 0):
            value = (1.0 if i == places[n] else 0.0) - (1.0 if i == 0 else 0.0)
            for k in range(order, 0, -1):
                last[k] = last[k - 1]
                if k <= i:
                    value -= factor[k, i - k] * last[k]
            last[0] = value / factor[0, i]
            variances[n] += last[0] ** 2
    return variances
