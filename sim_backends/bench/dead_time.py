"""Photons that are lost because the counter is still busy with one before."""

import numpy as np

from protocols import Floats, Integers


def non_paralyzable(expected: Floats, duration_s: Floats, dead_time_s: float, seed: list[int]) -> Integers:
    """Poisson arrivals thinned by a non-paralyzable dead time, exactly; each bin starts live.

    The counter is blocked for the dead time after each registered count, so it counts in live time, where counts come as
    a Poisson process of the true rate: k counts are registered if k exponential gaps and k - 1 dead times fit into the
    bin, G_k + (k - 1) tau <= T, with G_k gamma distributed. The largest such k is found by bisection, where G between
    two known values is beta distributed. Mean M = N / (1 + N tau / T) (Hamamatsu's handbook, eq. 6-2), variance over
    mean about 1 / (1 + N tau / T)^2.

    Args:
        expected: ``(n,)``: mean number of arrivals N without dead time.
        duration_s: ``(n,)``: length of each bin, T.
        dead_time_s: tau.
        seed: chooses the random numbers.

    Returns:
        ``(n,)``: registered counts.
    """
    if dead_time_s == 0:
        return np.random.default_rng([*seed, 0]).poisson(expected)
    rate_hz = np.divide(expected, duration_s, out=np.zeros_like(expected), where=duration_s > 0)
    # `few` counts fit, `many` do not: so many dead times alone are longer than the bin.
    few = np.zeros(len(expected), np.int64)
    many = (duration_s / dead_time_s).astype(np.int64) + 2
    gaps_few = np.zeros(len(expected))
    gaps_many = np.random.default_rng([*seed, 0]).gamma(many)
    step = 0
    while (many - few > 1).any():
        step += 1
        middle = (few + many) // 2
        share = np.random.default_rng([*seed, step]).beta(np.maximum(middle - few, 1), np.maximum(many - middle, 1))
        gaps = gaps_few + (gaps_many - gaps_few) * share
        fits = gaps <= rate_hz * (duration_s - (middle - 1) * dead_time_s)
        open_still = many - few > 1
        few, gaps_few = np.where(open_still & fits, (middle, gaps), (few, gaps_few))
        many, gaps_many = np.where(open_still & ~fits, (middle, gaps), (many, gaps_many))
        few, many = few.astype(np.int64), many.astype(np.int64)
    return few


def paralyzable(expected: Floats, duration_s: Floats, dead_time_s: float, seed: list[int]) -> Integers:
    """Poisson arrivals thinned by a paralyzable dead time, with the exact mean and variance; the bin lies in steady light.

    An arrival is registered if none came in the dead time before it, with probability exp(-n tau): n exp(-n tau) a second
    (Knoll, Radiation Detection and Measurement, chapter 4; for photon counting Opt. Express 29, 37945, 2021). Two registered
    counts are never closer than tau, and independent beyond, so that with the mean M = N exp(-N tau / T) the variance is
    M - M^2 (2 tau T - tau^2) / T^2. A binomial distribution with T^2 / (2 tau T - tau^2) trials, about one in two dead times,
    and the mean M has just this variance, but for the rounding of the trials to a whole number.

    Args:
        expected: ``(n,)``: mean number of arrivals N without dead time.
        duration_s: ``(n,)``: length of each bin, T.
        dead_time_s: tau.
        seed: chooses the random numbers.

    Returns:
        ``(n,)``: registered counts.
    """
    random = np.random.default_rng([*seed, 0])
    if dead_time_s == 0:
        return random.poisson(expected)
    busy = np.divide(dead_time_s, duration_s, out=np.ones_like(duration_s), where=duration_s > 0)
    mean = expected * np.exp(-np.minimum(expected * busy, 700.0)) * (duration_s > 0)
    within = np.minimum(busy, 1.0)
    # More than 1e15 trials are Poisson's distribution to every digit.
    trials = np.rint(np.minimum(1 / (within * (2 - within)), 1e15)).astype(np.int64)
    counted: Integers = random.binomial(trials, mean / trials)
    return counted
