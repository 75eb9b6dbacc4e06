"""Data-driven smoothing of an equidistant series, with weights and gaps.

Splines of several orders and of many strengths are fitted. Within an order they are averaged, each weighted by its posterior
probability (from the restricted likelihood), so that a rough series is followed and a smooth one is smoothed. Between orders
generalised cross-validation decides.

References:
    G. Wahba, Annals of Statistics 13 (1985) 1378-1402: likelihood against cross-validation.
    J. A. Hoeting et al., Statistical Science 14 (1999) 382-417: averages over models.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from instrument.numerics.spline import Spline
from protocols import Floats, InputError, Integers, Mask

ORDERS: Final = (1, 2, 3, 4)
"""Orders to choose among, from a random walk to changing acceleration."""

_EQUAL_SCORES = 1.005  # ratio of cross-validation scores below which two orders are equally good
_WEAKEST, _STRONGEST = -2.0, 24.0  # log10 of the strength; beyond these, rounding errors show
_STOPPED = 2.0  # log10 of a mode's penalty over its weight at which nothing of the mode passes
_GRID_STEP = 1.0  # log10 of the strength, times the order, between the strengths tried first
_FINE_GRID = 7  # number of strengths tried between the probable ones
_LEAST_PROBABILITY = 0.03  # relative to the most probable strength, below which a strength is left out
_VARIANCE_POSITIONS = 65  # number of positions, evenly spread, at which a variance is computed
_LONG_GAP = 3  # frames without data from which on the variance is computed in their middle too


@dataclass(frozen=True, eq=False)
class Smooth:
    """A smoothed series: the mean of splines of one order, each weighted by the posterior probability of its strength."""

    noise_variance: float
    """Estimated variance of a datum of mean weight."""

    splines: tuple[Spline, ...]
    """The splines of all probable strengths."""

    probabilities: tuple[float, ...]
    """Posterior probability of each spline; they sum to 1."""

    @cached_property
    def values(self) -> Floats:
        """``(n,)``: the smoothed series, gaps filled."""
        mean: Floats = np.einsum("s,sn->n", self.probabilities, [spline.values for spline in self.splines])
        return mean

    @cached_property
    def variance_to_first(self) -> Floats:
        """``(n,)``: posterior variance of each value minus the first one; see ``variance_to``."""
        return self.variance_to(0)

    def variance_to(self, origin: int) -> Floats:
        """Give the posterior variance, ``(n,)``, of each value minus that at a position.

        It is the mean of the splines' own variances plus the variance among the splines, computed
        at some positions; the standard deviation is interpolated between them.
        """
        positions = _variance_positions(self.splines[0].weights > 0, origin)
        total = np.zeros(len(positions))
        mean = self.values[positions] - self.values[origin]
        for probability, spline in zip(self.probabilities, self.splines, strict=True):
            deviation = spline.values[positions] - spline.values[origin] - mean
            total += probability * (self.noise_variance * spline.variances_to(origin, positions) + deviation**2)
        variance: Floats = np.interp(np.arange(len(self.values)), positions, np.sqrt(total)) ** 2
        return variance

    def covariance_to(self, origin: int, positions: Integers) -> Floats:
        """Give the posterior covariance, ``(k, k)``, of the values at these ``(k,)`` positions minus that at ``origin``.

        Its diagonal is ``variance_to``, but for the interpolation there.
        """
        total = np.zeros((len(positions), len(positions)))
        mean = self.values[positions] - self.values[origin]
        for probability, spline in zip(self.probabilities, self.splines, strict=True):
            deviation = spline.values[positions] - spline.values[origin] - mean
            of_spline = self.noise_variance * spline.covariance_to(origin, positions)
            total += probability * (of_spline + np.outer(deviation, deviation))
        return total

    def precision_of(self, basis: Floats) -> Floats:
        """Give the prior precision, ``(k, k)``, of coefficients of ``(n, k)`` series, for the geometric mean of the strengths."""
        differences = np.diff(basis, self.order, axis=0)
        logarithms = np.log([spline.strength for spline in self.splines])
        strength = float(np.exp(np.dot(self.probabilities, logarithms)))
        precision: Floats = strength / self.noise_variance * (differences.T @ differences)
        return precision

    @property
    def order(self) -> int:
        """p: the order of the differences that are kept small."""
        return self.splines[0].order

    @property
    def degrees_of_freedom(self) -> float:
        """Effective number of parameters, averaged over the splines."""
        pairs = zip(self.probabilities, self.splines, strict=True)
        return sum(probability * spline.degrees_of_freedom for probability, spline in pairs)

    def cross_validation(self, series: Floats) -> float:
        """Generalised cross-validation score of this fit to ``series``: its mean squared error in predicting left-out data."""
        data = self.splines[0].data
        misfit = float(np.sum(self.splines[0].weights * (series - self.values) ** 2))
        return data * misfit / (data - self.degrees_of_freedom) ** 2


def smooth(
    series: Floats, weights: Floats, *, orders: Sequence[int] = ORDERS, absolute_weights: bool = False
) -> Smooth:
    """Smooth a series as far as its data allow.

    Args:
        series: ``(n,)`` equidistant data; an entry whose weight is 0 is ignored.
        weights: ``(n,)`` relative inverse variances, at least eight of them above 0.
        orders: orders p to choose among. Of those that predict left-out data equally well, the one with the fewest degrees of
            freedom is taken.
        absolute_weights: whether the weights are inverse variances by size too. The noise is then kept within 0.8 to 1.5 times
            what they say, so that fast motion is not mistaken for noise, nor noise for motion. Otherwise it is estimated freely.

    Raises:
        InputError: the numbers are so large or so small that no fit has a finite error.
    """
    present = weights > 0
    noise = 1 / float(weights[present].mean())
    noise_bounds = (0.8 * noise, 1.5 * noise) if absolute_weights else (1e-300, np.inf)
    data = _Data(np.where(present, series, 0.0), weights * noise, noise_bounds)
    fits = [_averaged(data, order) for order in orders]
    scores = [fit.cross_validation(data.series) for fit in fits]
    if not np.isfinite(scores).all():
        raise InputError(
            saw=f"a series from {data.series.min():.3g} to {data.series.max():.3g} that no curve predicts",
            expected="a signal and its noise",
            remedy="look at the values for wild counts, and for what never changes",
        )
    best = [fit for fit, score in zip(fits, scores, strict=True) if score <= _EQUAL_SCORES * min(scores)]
    return min(best, key=lambda fit: fit.degrees_of_freedom)


@dataclass(frozen=True, eq=False)
class _Data:
    """What splines are fitted to."""

    series: Floats
    """``(n,)``: data; 0 in gaps."""

    weights: Floats
    """``(n,)``: weights of mean 1 where there are data; 0 in gaps."""

    noise_bounds: tuple[float, float]
    """Lowest and highest variance allowed for a datum of weight 1."""


@dataclass(frozen=True, eq=False)
class _Posterior:
    """Splines of one order and several strengths. Each sequence has one entry for each strength."""

    splines: list[Spline]
    """The splines."""

    probabilities: Floats
    """Posterior probability of each strength; 0 for those left out; they sum to 1."""

    noise_variance: Floats
    """Variance of a datum of weight 1 as each spline estimates it."""

    @classmethod
    def of(cls, data: _Data, order: int, log_strengths: Floats) -> "_Posterior":
        """Fit a spline for each strength, given by its log10; all strengths have the same prior probability."""
        splines = [
            Spline.through(data.series, data.weights, order, float(10.0**log_strength))
            for log_strength in log_strengths
        ]
        noise = np.clip([spline.cost / (spline.data - order) for spline in splines], *data.noise_bounds)
        log_likelihood = np.array(
            [spline.log_likelihood(own) for spline, own in zip(splines, noise.tolist(), strict=True)]
        )
        probabilities = np.exp(log_likelihood - log_likelihood.max())
        probabilities[probabilities < _LEAST_PROBABILITY] = 0
        return cls(splines, probabilities / probabilities.sum(), noise)


def _averaged(data: _Data, order: int) -> Smooth:
    """Average the splines of one order over a fine grid of strengths, laid where a coarse one finds them probable."""
    grid = _coarse_grid(len(data.series), order)
    probable = np.flatnonzero(_Posterior.of(data, order, grid).probabilities)
    first, last = max(probable[0] - 1, 0), min(probable[-1] + 1, len(grid) - 1)
    fine = _Posterior.of(data, order, np.linspace(grid[first], grid[last], _FINE_GRID))
    kept = np.flatnonzero(fine.probabilities).tolist()
    return Smooth(
        noise_variance=float(fine.probabilities @ fine.noise_variance),
        splines=tuple(fine.splines[k] for k in kept),
        probabilities=tuple(fine.probabilities[kept].tolist()),
    )


def _coarse_grid(size: int, order: int) -> Floats:
    """List log10 of strengths from hardly any smoothing to one that leaves nothing but a polynomial.

    A spline averages over about lambda^(1 / 2p) neighbours, so that the step between strengths grows with the order.
    """
    lowest_mode = (order + 1) / 2 * np.pi / size  # rad per datum: the slowest that is no polynomial
    strongest = min(_STOPPED - 2 * order * float(np.log10(lowest_mode)), _STRONGEST)
    return np.linspace(_WEAKEST, strongest, 1 + max(2, round((strongest - _WEAKEST) / (_GRID_STEP * order))))


def _variance_positions(present: Mask, origin: int) -> Integers:
    """Choose where a variance is computed.

    Densely near the position that it counts from, at both ends and in the middle of gaps, and evenly.
    """
    count = len(present)
    changes = np.flatnonzero(np.diff(present, prepend=True, append=True))
    start, end = changes[::2], changes[1::2]
    middle = ((start + end) // 2)[end - start >= _LONG_GAP]
    near = 2 ** np.arange(int(np.log2(count)) + 1)
    even = np.linspace(0, count - 1, min(count, _VARIANCE_POSITIONS)).round().astype(np.int64)
    around = [origin - near, [origin], origin + near]
    return np.unique(np.concatenate([*around, even, middle, start, end]).clip(0, count - 1))
