"""Counts that are no photons: afterpulses of the tube, and bins that are read far too high."""

from typing import Final

import numpy as np

from protocols import Counts, Floats, Integers

_SAME_BIN: Final = 1001
_NEXT_BIN: Final = 1002
_BEFORE: Final = 1003
_SPIKES: Final = 1004
"""Streams of random numbers, apart from those of the photons, which they leave as they are."""

_MOST: Final = 2**32 - 1


def afterpulses(
    counted: Integers, before: float, duration_s: Floats, *, probability: float, delay_s: float, seed: list[int]
) -> Integers:
    """False counts that follow true ones at an exponential delay, in the same bin or in the next.

    Of the counts that lie evenly in a bin of length T, the part (d / T)(1 - exp(-T / d)) has its afterpulse after the end
    of the bin, d being the mean delay. Delays are meant to be well below T: what comes later than the next bin is in the next.

    Args:
        counted: ``(n,)`` counts of the bins of one stretch.
        before: mean counts of the bin before the first of them.
        duration_s: ``(n,)`` length of each bin, T.
        probability: of an afterpulse, for each count.
        delay_s: d.
        seed: of the stretch.

    Returns:
        ``(n,)`` afterpulses.
    """
    part = delay_s / np.maximum(duration_s, 1e-300)
    beyond = part * -np.expm1(-1 / part)
    same = np.random.default_rng([*seed, _SAME_BIN]).binomial(counted, probability * (1 - beyond))
    first = np.random.default_rng([*seed, _BEFORE]).poisson(before, 1)
    came_before = np.concatenate([first, counted[:-1]])
    lag = np.concatenate([beyond[:1], beyond[:-1]])
    return same + np.random.default_rng([*seed, _NEXT_BIN]).binomial(came_before, probability * lag)


def with_spikes(values: Counts, probability: float, factor: float, seed: list[int]) -> Counts:
    """Multiply single values of one stretch, drawn with ``probability``, by ``factor``; counts stay whole and within 32 bits."""
    hit = np.random.default_rng([*seed, _SPIKES]).random(len(values)) < probability
    spiked = np.where(hit, values * factor, values)
    return np.minimum(np.rint(spiked), _MOST).astype(np.uint32) if values.dtype == np.uint32 else spiked
