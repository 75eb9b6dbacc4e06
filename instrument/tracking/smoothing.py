"""Data-driven smoothing of an equidistant series, with known weights and gaps, in time proportional to its length.

The discrete smoothing spline: the x that minimises sum w (z - x)^2 + strength * sum (p-th differences of x)^2. Seen as
statistics, z has independent noise of variance v / w and x is a p-fold integrated random walk; strength is v over the variance
of its steps, and the value under which z is most likely (restricted maximum likelihood) is taken, so that a rough series is
followed and a smooth one is smoothed.

References:
    Whittaker, Proc. Edinburgh Math. Soc. 41 (1923) 63-75. Eilers, Analytical Chemistry 75 (2003) 3631-3636.
    Wahba, Annals of Statistics 13 (1985) 1378-1402: likelihood against cross-validation.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import comb

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from protocols import Floats

ORDERS = (2, 3, 1)
"""Orders in the order of preference: another one must be better to be taken."""

_BETTER = 1.005  # by this ratio of cross-validation scores
_STRONGEST = {1: 6.0, 2: 11.0, 3: 13.0}  # powers of ten; beyond, rounding errors of the band matrix show
_STEP = 1.5  # decades between the strengths tried first


@dataclass(frozen=True, eq=False)
class Smooth:
    """A smoothed series and what is known about its errors."""

    values: Floats
    """``(n,)``: the series, gaps filled."""

    noise_variance: float
    """Of a datum of mean weight."""

    order: int
    """p: which differences were kept small."""

    strength: float
    """How much they count."""

    _factor: Floats
    """``(p + 1, n)``: Cholesky factor of W + strength D'D, lower band form."""

    _weights: Floats
    """Of mean 1 over the data present."""

    def cross_validation(self, series: Floats) -> float:
        """Generalised cross-validation score of this fit to ``series``: its mean squared error in predicting left-out data."""
        count = int(np.count_nonzero(self._weights))
        misfit = float(np.sum(self._weights * (series - self.values) ** 2))
        used = _passed(len(series), self.order, self.strength * len(series) / count).sum() * count / len(series)
        return count * misfit / (count - float(used)) ** 2

    @cached_property
    def variance_to_first(self) -> Floats:
        """``(n,)``: posterior variance of each value minus the first one's."""
        first = np.zeros(len(self.values))
        first[0] = 1.0
        to_first = _solve(self._factor, first)
        spline = self._own + to_first[0] - 2 * to_first
        # The cubic that was taken off, by least squares. What both may bend counts twice: that errs on the safe side.
        base = _cubic_base(len(self.values))
        step = base - base[0]
        cubic = np.einsum("ki,ij,kj->k", step, np.linalg.inv(base.T @ (self._weights[:, None] * base)), step)
        variance: Floats = self.noise_variance * np.maximum(spline + cubic, 0.0)
        variance[0] = 0.0
        return variance

    @cached_property
    def _own(self) -> Floats:
        """Diagonal of the inverse of W + strength D'D, from its band (Takahashi's recursion, written out for p <= 3)."""
        pivot: list[float] = (1 / self._factor[0] ** 2).tolist()
        below = np.zeros((3, len(pivot)))
        below[: self.order] = self._factor[1:] / self._factor[0]
        rows: list[tuple[float, float, float]] = list(zip(*below.tolist(), strict=True))
        own = [0.0] * len(pivot)
        # Inverse's elements (i+1, i+1), (i+1, i+2), (i+1, i+3), (i+2, i+2), (i+2, i+3), (i+3, i+3).
        a = b = c = d = e = f = 0.0
        for i in range(len(pivot) - 1, -1, -1):
            m1, m2, m3 = rows[i]
            z1 = -(m1 * a + m2 * b + m3 * c)
            z2 = -(m1 * b + m2 * d + m3 * e)
            z3 = -(m1 * c + m2 * e + m3 * f)
            own[i] = pivot[i] - (m1 * z1 + m2 * z2 + m3 * z3)
            a, b, c, d, e, f = own[i], z1, z2, a, b, d
        return np.array(own)


def smooth(
    series: Floats,
    weights: Floats,
    *,
    orders: tuple[int, ...] = ORDERS,
    known: bool = False,
    near: Smooth | None = None,
) -> Smooth:
    """Smooth a series as far as its data allow.

    A cubic through the data is taken off first and put back, so that long smooth runs keep their digits.

    Args:
        series: ``(n,)``: equidistant data; what stands where the weight is 0 does not count.
        weights: ``(n,)``: inverse variances, eight or more of them above 0.
        orders: which p to choose among, the preferred first.
        known: whether weights are inverse variances by size too. The noise is then kept within 0.8 to 1.5 times what they say,
            so that fast motion is not mistaken for noise, nor noise for motion. Else it is estimated freely.
        near: an earlier result for nearly the same data: only strengths near its own are tried.
    """
    present = weights > 0
    noise = 1 / float(weights[present].mean())
    weights = weights * noise
    bounds = (0.8 * noise, 1.5 * noise) if known else (1e-300, np.inf)
    base = _cubic_base(len(series))
    root = np.sqrt(weights)[:, None]
    cubic: Floats = base @ np.linalg.lstsq(root * base, root[:, 0] * np.where(present, series, 0.0))[0]
    rest = np.where(present, series - cubic, 0.0)
    if near is not None:
        middle = min(float(np.log10(near.strength)), _STRONGEST[near.order] - 1)
        fits = [_most_likely(rest, weights, near.order, bounds, middle + np.array([-1.0, 0.0, 1.0]))]
    else:
        fits = [
            _most_likely(rest, weights, order, bounds, np.arange(-2.0, _STRONGEST[order] + 0.1, _STEP))
            for order in orders
        ]
    scores = [fit.cross_validation(rest) for fit in fits]
    chosen = next(fit for fit, score in zip(fits, scores, strict=True) if score <= _BETTER * min(scores))
    return replace(chosen, values=chosen.values + cubic)


def _most_likely(series: Floats, weights: Floats, order: int, bounds: tuple[float, float], powers: Floats) -> Smooth:
    """Try strengths of these powers of ten, and the vertex of the parabola through the best three."""
    fits = [_fit(series, weights, order, 10.0**power, bounds) for power in powers]
    found = np.array([likelihood for _, likelihood in fits])
    best = int(np.clip(np.argmin(found), 1, len(powers) - 2))
    low, middle, high = found[best - 1 : best + 2]
    curved = low - 2 * middle + high
    if curved > 0:
        aside = float(np.clip((low - high) / (2 * curved), -1, 1))
        fits.append(_fit(series, weights, order, 10.0 ** (powers[best] + aside * (powers[1] - powers[0])), bounds))
    return min(fits, key=lambda fit: fit[1])[0]


def _fit(
    series: Floats, weights: Floats, order: int, strength: float, bounds: tuple[float, float]
) -> tuple[Smooth, float]:
    """Smooth with one strength, and -2 log of the restricted likelihood of that strength, but for a constant."""
    size = len(series)
    matrix = strength * _penalty(size, order)
    matrix[0] += weights
    factor: Floats = cholesky_banded(matrix, lower=True, check_finite=False)
    values = _solve(factor, weights * series)
    freedom = int(np.count_nonzero(weights)) - order
    cost = float(np.sum(weights * series * (series - values)))
    noise = min(max(cost / freedom, bounds[0]), bounds[1])
    likelihood = (
        freedom * np.log(noise) + cost / noise + 2 * float(np.log(factor[0]).sum()) - (size - order) * np.log(strength)
    )
    return Smooth(values, noise, order, strength, factor, weights), likelihood


def _cubic_base(size: int) -> Floats:
    return np.asarray(np.polynomial.legendre.legvander(np.linspace(-1, 1, size), 3), np.float64)


def _solve(factor: Floats, right: Floats) -> Floats:
    solution: Floats = cho_solve_banded((factor, True), right, check_finite=False)
    return solution


@lru_cache(maxsize=8)
def _penalty(size: int, order: int) -> Floats:
    """D'D of the ``order``-th differences, ``(order + 1, size)`` in lower band form."""
    band = np.zeros((order + 1, size))
    taps = [(-1) ** (order - i) * comb(order, i) for i in range(order + 1)]
    for below in range(order + 1):
        for i in range(order + 1 - below):
            band[below, i : i + size - order] += taps[i] * taps[i + below]
    return band


def _passed(size: int, order: int, strength: float) -> Floats:
    """Share of each eigenvector of D'D that passes the filter, by the eigenvalues' asymptotic form (free ends)."""
    angle = np.maximum(np.arange(size) - (order - 1) / 2, 0.0) * np.pi / size
    angle[:order] = 0.0
    passed: Floats = 1 / (1 + strength * (2 * np.sin(angle / 2)) ** (2 * order))
    return passed
