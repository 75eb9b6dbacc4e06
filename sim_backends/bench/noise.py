"""From light to what the counter reads: exact, Gaussian a pixel, or photons.

Random numbers are drawn stretch by stretch of bins, each stretch from its own seed, and inside a stretch in bin order. So
a bin's count depends on the seed, on its own light and on the bins before it in its stretch: never on how often or in what
blocks it was read.
"""

import numpy as np

from protocols import Counts, Floats, InputError, Integers
from sim_backends.bench.dead_time import non_paralyzable, paralyzable
from sim_backends.bench.noise_settings import NoNoise, PhotonNoise, PixelNoise
from sim_backends.bench.pulses import afterpulses


def measure(
    noise: NoNoise | PixelNoise | PhotonNoise,
    stretch: int,
    *,
    light: Floats,
    lit_px: Floats,
    duration_s: Floats,
    counts_per_light: float,
    light_before: float = 0.0,
) -> Counts:
    """What the counter reads in the bins of one stretch.

    Args:
        noise: the scene's noise.
        stretch: index of this stretch of bins in the run, which chooses the random numbers.
        light: ``(n,)``, in transmission times px.
        lit_px: ``(n,)``: lit image pixels, for ``pixel`` noise.
        duration_s: ``(n,)``: length of each bin.
        counts_per_light: photons a unit of light, for ``poisson``.
        light_before: light of the picture time before the first bin, of which afterpulses may come.

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
            seed = [noise.seed, stretch]
            counted = _registered(expected, duration_s, noise, seed)
            if noise.afterpulse_probability:
                counted += afterpulses(
                    counted,
                    light_before * counts_per_light,
                    duration_s,
                    probability=noise.afterpulse_probability,
                    delay_s=noise.afterpulse_delay_s,
                    seed=seed,
                )
            return counted.astype(np.uint32)


def _check_counts(expected: Floats) -> None:
    if not (expected < 2**31).all():  # half of what fits: chance must not take a count beyond it
        raise InputError(
            device="bench",
            saw=f"{float(expected.max()):.3g} photons in one picture",
            expected="fewer than 2^31: counts have 32 bits",
            remedy="lower peak_counts, dark_rate_hz, light_level, background_level or ambient_level in [scene]",
        )


def _registered(expected: Floats, duration_s: Floats, noise: PhotonNoise, seed: list[int]) -> Integers:
    """``(n,)``: counts that the dead time leaves of ``expected`` (n,) photons."""
    count = paralyzable if noise.dead_time_kind == "paralyzable" else non_paralyzable
    return count(expected, duration_s, noise.dead_time_s, seed)
