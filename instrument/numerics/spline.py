"""The discrete smoothing spline of one order and one strength, in time proportional to its length.

The spline is the series x that minimises sum w (z - x)^2 + lambda sum (D x)^2, where z are the data, w their weights, D x the
p-th differences of x and lambda the strength. In statistical terms, z has independent noise of variance v / w, x is a p-fold
integrated random walk, and lambda is v over the variance of the walk's steps. The strongest smoothing leaves a polynomial of
degree p - 1.

It is solved as a least-squares problem, by rotations that take in one datum and one difference after the other. The normal
equations, which are quicker to solve, lose all digits of a smooth series (``docs/decisions/0010-smooth-paths.md``).

References:
    E. T. Whittaker, Proc. Edinburgh Math. Soc. 41 (1923) 63-75. P. H. C. Eilers, Analytical Chemistry 75 (2003) 3631-3636.
"""

from dataclasses import dataclass
from math import comb

import numpy as np

from instrument.numerics.compiled import compiled, inlined
from protocols import Floats, Integers


@dataclass(frozen=True, eq=False)
class Spline:
    """A smoothed series, and what is known about its errors."""

    values: Floats
    """``(n,)``: the series x, gaps filled."""

    order: int
    """p: the order of the differences that are kept small."""

    strength: float
    """lambda: the weight of the squared differences."""

    cost: float
    """The minimum of weighted squares and penalty."""

    weights: Floats
    """``(n,)``: weights w of the data; 0 in gaps."""

    _factor: Floats
    """``(p + 1, n)``: Cholesky factor of W + lambda D'D in lower band form, row k holding the k-th subdiagonal."""

    @classmethod
    def through(cls, series: Floats, weights: Floats, order: int, strength: float) -> "Spline":
        """Fit to ``(n,)`` equidistant data with these weights, at least ``order`` of them above 0."""
        factor, values = np.empty((order + 1, len(series))), np.empty(len(series))
        difference = np.array([float((-1) ** (order - k) * comb(order, k)) for k in range(order + 1)])
        cost = _least_squares(series, weights, difference, strength, factor, values)
        return cls(values, order, strength, cost, weights, factor)

    @property
    def data(self) -> int:
        """Number of data that it was fitted to."""
        return int(np.count_nonzero(self.weights))

    @property
    def degrees_of_freedom(self) -> float:
        """Effective number of parameters: the trace of the matrix that gives ``values`` from the data.

        It is the sum over the modes of D'D of the share that the penalty lets through, each mode's eigenvalue taken in its
        asymptotic form for free ends.
        """
        size, count = len(self.values), self.data
        angle = np.maximum(np.arange(size) - (self.order - 1) / 2, 0.0) * np.pi / size
        angle[: self.order] = 0.0
        penalty = self.strength * size / count * (2 * np.sin(angle / 2)) ** (2 * self.order)
        return float((1 / (1 + penalty)).sum()) * count / size

    def log_likelihood(self, noise_variance: float) -> float:
        """Give the restricted log likelihood of order and strength, up to a constant that depends on the order alone.

        It is the likelihood of those combinations of the data that no polynomial of degree p - 1 changes.

        Args:
            noise_variance: v, the variance of a datum of weight 1.
        """
        count = self.data - self.order
        log_determinant = 2 * float(np.log(self._factor[0]).sum())
        log_determinant -= (len(self.values) - self.order) * np.log(self.strength)
        return -(count * float(np.log(noise_variance)) + self.cost / noise_variance + float(log_determinant)) / 2

    def variances_to(self, origin: int, positions: Integers) -> Floats:
        """Give the posterior variances of the values at these positions minus that at ``origin``.

        The noise has variance 1 at weight 1.
        """
        return _variances_to(self._factor, origin, positions)

    def covariance_to(self, origin: int, positions: Integers) -> Floats:
        """Give likewise the posterior covariance, ``(k, k)``, of the values at these ``(k,)`` positions minus that at ``origin``.

        With L the Cholesky factor of the normal matrix, entry k, l is the product of y_k and y_l, where L y_k = e_k - e_origin.
        """
        from scipy.linalg import solve_banded  # noqa: PLC0415 - slow to load: not while a counter counts

        right = np.zeros((len(self.values), len(positions)))
        right[positions, np.arange(len(positions))] += 1
        right[origin] -= 1
        solved = solve_banded((self.order, 0), self._factor, right)
        covariance: Floats = solved.T @ solved
        return covariance


@inlined
def _rotate_in(weight: float, row: Floats, triangle: Floats, diagonal: Floats) -> float:
    """Take one more equation into a triangular system, by square-root-free Givens rotations.

    Args:
        weight: weight of the equation.
        row: ``(n + 1,)`` its coefficients and, last, its right side; overwritten.
        triangle: ``(n, n + 1)`` unit upper triangle with the right sides in the last column; updated.
        diagonal: ``(n,)`` weight of each equation of the triangle; updated.

    Returns:
        Weighted square of the residual that the system cannot remove.

    References:
        W. M. Gentleman, J. Inst. Math. Appl. 12 (1973) 329-336.
    """
    for k in range(len(diagonal)):
        if weight == 0:
            break
        if row[k] != 0:
            coefficient = row[k]
            inverse = 1 / (diagonal[k] + weight * coefficient * coefficient)
            cosine, sine = diagonal[k] * inverse, weight * coefficient * inverse
            diagonal[k] += weight * coefficient * coefficient
            weight *= cosine
            for j in range(k + 1, len(row)):
                before = row[j]
                row[j] = before - coefficient * triangle[k, j]
                triangle[k, j] = cosine * triangle[k, j] + sine * before
    residual: float = weight * row[-1] ** 2
    return residual


@inlined
def _drop_first_unknown(triangle: Floats, diagonal: Floats) -> None:
    """Move the triangle on by one unknown: no later equation holds its first one, and the new last one has no equation yet."""
    order = len(diagonal) - 1
    for k in range(order):
        diagonal[k], triangle[k, -1] = diagonal[k + 1], triangle[k + 1, -1]
        for j in range(k + 1, order):
            triangle[k, j] = triangle[k + 1, j + 1]
        triangle[k, order] = 0
    diagonal[order] = 0
    triangle[order] = 0


@compiled("f8(f8[::1], f8[::1], f8[::1], f8, f8[:, ::1], f8[::1])")
def _least_squares(  # noqa: PLR0917
    series: Floats, weights: Floats, difference: Floats, strength: float, factor: Floats, values: Floats
) -> float:
    """Minimise sum w (z - x)^2 + lambda sum (D x)^2.

    The triangle holds the p + 1 unknowns from x[i] on. After the last equation with x[i] its first row is final: it is a row
    of the Cholesky factor.

    Args:
        series: ``(n,)`` z.
        weights: ``(n,)`` w.
        difference: ``(p + 1,)`` coefficients of one p-th difference.
        strength: lambda.
        factor: ``(p + 1, n)``; receives the Cholesky factor of W + lambda D'D, lower band form.
        values: ``(n,)``; receives x.

    Returns:
        The minimum.
    """
    count, order = len(series), len(difference) - 1
    triangle, diagonal, row = np.zeros((order + 1, order + 2)), np.zeros(order + 1), np.zeros(order + 2)
    cost = 0.0
    for i in range(count):
        if weights[i] > 0:
            row[:] = 0
            row[0], row[-1] = 1, series[i]
            cost += _rotate_in(weights[i], row, triangle, diagonal)
        if i + order < count:
            row[:-1], row[-1] = difference, 0
            cost += _rotate_in(strength, row, triangle, diagonal)
        root = np.sqrt(diagonal[0])
        factor[0, i], values[i] = root, triangle[0, -1]
        for k in range(1, order + 1):
            factor[k, i] = root * triangle[0, k]
        _drop_first_unknown(triangle, diagonal)
    for i in range(count - 2, -1, -1):  # back substitution
        for k in range(1, min(order, count - 1 - i) + 1):
            values[i] -= factor[k, i] / factor[0, i] * values[i + k]
    return cost


@compiled("f8[::1](f8[:, ::1], i8, i8[::1])")
def _variances_to(factor: Floats, origin: int, positions: Integers) -> Floats:
    """Give the variances of x[k] - x[origin] for the positions k, ``(len(positions),)``.

    With L the Cholesky factor of the normal matrix and e_k the k-th unit vector, that is |y|^2 where L y = e_k - e_origin.
    """
    order, count = len(factor) - 1, factor.shape[1]
    variances = np.zeros(len(positions))
    recent = np.zeros(order + 1)  # the last entries of y, the newest first
    for n in range(len(positions)):
        recent[:] = 0
        for i in range(count if positions[n] != origin else 0):
            value = (1.0 if i == positions[n] else 0.0) - (1.0 if i == origin else 0.0)
            for k in range(order, 0, -1):
                recent[k] = recent[k - 1]
                if k <= i:
                    value -= factor[k, i - k] * recent[k]
            recent[0] = value / factor[0, i]
            variances[n] += recent[0] ** 2
    return variances
