"""From light to what the counter reads: exact, Gaussian a pixel, or photons.

Random numbers are drawn stretch by stretch of bins, each stretch from its own seed, and inside a stretch in bin order. So
a bin's count depends on the seed, on its own light and on the bins before it in its stretch: never on how often or in what
blocks it was read.
"""

import numpy as np

from protocols import Counts, Floats, InputError, Integers
from sim_backends.bench.settings import NoNoise, PhotonNoise, PixelNoise


def measure(
    noise: NoNoise | PixelNoise | PhotonNoise,
    stretch: int,
    *,
    light: Floats,
    lit_px: Floats,
    duration_s: Floats,
    counts_per_light: float,
) -> Counts:
    """What the counter reads in the bins of one stretch.

    Args:
        noise: the scene's noise.
        stretch: index of this stretch of bins in the run, which chooses the random numbers.
        light: ``(n,)``, in transmission times px.
        lit_px: ``(n,)``: lit image pixels, for ``pixel`` noise.
        duration_s: ``(n,)``: length of each bin.
        counts_per_light: photons a unit of light, for ``poisson``.

    Returns:
        ``(n,)``: uint32 for ``poisson``, float64 otherwise.

    Raises:
        InputError: so much light that its photons do not fit into 32 bits.
    """
    match noise:
        case NoNoise():
            return light
        case PixelNoise():
            random = np.random.default_rng([noise.seed, stretch])
            return light + noise.sigma * np.sqrt(lit_px) * random.standard_normal(len(light))
        case PhotonNoise():
            expected = light * counts_per_light + noise.dark_rate_hz * duration_s
            _check_counts(expected)
            return count_photons(expected, duration_s, noise.dead_time_s, [noise.seed, stretch]).astype(np.uint32)


def _check_counts(expected: Floats) -> None:
    if not (expected < 2**31).all():  # half of what fits: chance must not take a count beyond it
        raise InputError(
            device="bench",
            saw=f"{float(expected.max()):.3g} photons in one picture",
            expected="fewer than 2^31: counts have 32 bits",
            remedy="lower peak_counts, dark_rate_hz, light_level or background_level in [scene]",
        )


def count_photons(expected: Floats, duration_s: Floats, dead_time_s: float, seed: list[int]) -> Integers:
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
