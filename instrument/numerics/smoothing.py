"""Data-driven smoothing of an equidistant series, with known weights and gaps.

Splines of several orders and of all strengths are fitted. Within an order they are averaged, each as likely as the data make it
(restricted likelihood), so that a rough series is followed and a smooth one is smoothed. Between orders cross-validation decides.

References:
    Wahba, Annals of Statistics 13 (1985) 1378-1402: likelihood against cross-validation.
    Hoeting et al., Statistical Science 14 (1999) 382-417: averages over models.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from instrument.numerics.spline import Spline
from protocols import Floats, InputError, Integers, Mask

ORDERS = (1, 2, 3, 4)
"""From a random walk to changing acceleration."""

_EQUAL = 1.005  # ratio of cross-validation scores below which two orders are equally good
_WEAKEST, _STRONGEST = -2.0, 24.0  # powers of ten; beyond, rounding errors show
_STIFF = 2.0  # power of ten by which a mode's penalty exceeds its weight where nothing of it passes
_STEP = 1.0  # decades, times the order, between strengths looked at first: as the memory goes with strength^(1 / 2p)
_CLOSER = 7  # strengths looked at then
_UNLIKELY = 0.03  # chance of a strength over that of the likeliest, below which it is left out
_PLACES = 65  # at which a variance is worked out
_LONG_GAP = 3  # frames without data, from which on their middle is one of them


@dataclass(frozen=True, eq=False)
class Smooth:
    """A smoothed series and what is known about its errors: splines of one order, each with its chance to be the right one."""

    noise_variance: float
    """Of a datum of mean weight."""

    splines: tuple[Spline, ...]
    """The likely ones."""

    chances: tuple[float, ...]
    """Of each; their sum is 1."""

    @cached_property
    def values(self) -> Floats:
        """``(n,)``: the series, gaps filled: the mean of the splines."""
        mean: Floats = np.einsum("s,sn->n", self.chances, [spline.values for spline in self.splines])
        return mean

    @cached_property
    def variance_to_first(self) -> Floats:
        """``(n,)``: posterior variance of each value minus the first one's; from place to place it is interpolated.

        It is the mean of the splines' own variances, and the variance of the splines among each other.
        """
        places = _places(self.splines[0].weights > 0)
        total = np.zeros(len(places))
        here = self.values[places] - self.values[0]
        for chance, spline in zip(self.chances, self.splines, strict=True):
            aside = spline.values[places] - spline.values[0] - here
            total += chance * (self.noise_variance * spline.variances_to_first(places) + aside**2)
        variance: Floats = np.interp(np.arange(len(self.values)), places, np.sqrt(total)) ** 2
        return variance

    @property
    def order(self) -> int:
        """p: which differences were kept small."""
        return self.splines[0].order

    @property
    def freedom(self) -> float:
        """Degrees of freedom: how many data it could pass through."""
        return sum(chance * spline.freedom for chance, spline in zip(self.chances, self.splines, strict=True))

    def cross_validation(self, series: Floats) -> float:
        """Generalised cross-validation score of this fit to ``series``: its mean squared error in predicting left-out data."""
        data = self.splines[0].data
        misfit = float(np.sum(self.splines[0].weights * (series - self.values) ** 2))
        return data * misfit / (data - self.freedom) ** 2


def smooth(series: Floats, weights: Floats, *, orders: tuple[int, ...] = ORDERS, known: bool = False) -> Smooth:
    """Smooth a series as far as its data allow.

    Args:
        series: ``(n,)``: equidistant data; what stands where the weight is 0 does not count.
        weights: ``(n,)``: inverse variances, eight or more of them above 0.
        orders: which p to choose among: of those that predict left-out data equally well, the one with fewest degrees of freedom.
        known: whether weights are inverse variances by size too. The noise is then kept within 0.8 to 1.5 times what they say,
            so that fast motion is not mistaken for noise, nor noise for motion. Else it is estimated freely.

    Raises:
        InputError: numbers so large or so small that no fit has a finite error.
    """
    present = weights > 0
    noise = 1 / float(weights[present].mean())
    bounds = (0.8 * noise, 1.5 * noise) if known else (1e-300, np.inf)
    series = np.where(present, series, 0.0)
    fits = [_likely(series, weights * noise, order, bounds) for order in orders]
    scores = [fit.cross_validation(series) for fit in fits]
    if not np.isfinite(scores).all():
        saw, expected = (
            f"a series from {series.min():.3g} to {series.max():.3g} that no curve predicts",
            "a signal and its noise",
        )
        raise InputError(
            saw=saw, expected=expected, remedy="look at the values for wild counts, and for what never changes"
        )
    equal = [fit for fit, score in zip(fits, scores, strict=True) if score <= _EQUAL * min(scores)]
    return min(equal, key=lambda fit: fit.freedom)


def _likely(series: Floats, weights: Floats, order: int, noise_bounds: tuple[float, float]) -> Smooth:
    """Look from hardly any smoothing to the strength that leaves a polynomial and no more, then closer where it is likely."""
    size = len(series)
    strongest = min(_STIFF - 2 * order * float(np.log10((order + 1) / 2 * np.pi / size)), _STRONGEST)
    powers = np.linspace(_WEAKEST, strongest, 1 + max(2, round((strongest - _WEAKEST) / (_STEP * order))))
    likely = np.flatnonzero(_weighed(series, weights, order, powers, noise_bounds)[0])
    closer = powers[max(likely[0] - 1, 0)], powers[min(likely[-1] + 1, len(powers) - 1)]
    chances, splines, noise = _weighed(series, weights, order, np.linspace(*closer, _CLOSER), noise_bounds)
    kept = np.flatnonzero(chances).tolist()
    return Smooth(float(chances @ noise), tuple(splines[k] for k in kept), tuple(chances[kept].tolist()))


def _weighed(
    series: Floats, weights: Floats, order: int, powers: Floats, noise_bounds: tuple[float, float]
) -> tuple[Floats, list[Spline], Floats]:
    """Splines whose strengths are these powers of ten: their chances, 0 for the unlikely, themselves, and their noise."""
    splines = [Spline.through(series, weights, order, float(10.0**power)) for power in powers]
    noise = np.clip([spline.cost / (spline.data - order) for spline in splines], *noise_bounds)
    found = np.array([spline.log_likelihood(own) for spline, own in zip(splines, noise.tolist(), strict=True)])
    chances = np.exp(found - found.max())
    chances[chances < _UNLIKELY] = 0
    return chances / chances.sum(), splines, noise


def _places(present: Mask) -> Integers:
    """Places where a variance is worked out: close together at the first, in long gaps, at their ends, and here and there."""
    count = len(present)
    changes = np.flatnonzero(np.diff(present, prepend=True, append=True))
    start, end = changes[::2], changes[1::2]
    middle = ((start + end) // 2)[end - start >= _LONG_GAP]
    near, far = 2 ** np.arange(int(np.log2(count)) + 1), np.linspace(0, count - 1, min(count, _PLACES))
    places = np.concatenate([near, far.round().astype(np.int64), middle, start, end])
    return np.unique(places.clip(0, count - 1))
