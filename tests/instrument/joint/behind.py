"""A run with a background that nobody measured: the "B" of the benchmarks and a bar, 128 x 128 px, 800 frames."""

from functools import cache

import numpy as np

from instrument.plan import Plan
from instrument.recording import Recording
from protocols import Floats
from tests.support.motions import letter_b
from tests.support.plans import plan_of
from tests.support.simulation import simulate

FRAMES = 800
RUN_S = FRAMES * 300e-6


def path(time_s: Floats) -> Floats:
    """70 px across and 60 px down, in a gentle curve."""
    part = time_s / RUN_S
    across = 70 * part + 4 * np.sin(2 * np.pi * part)
    return np.stack([across, 8 * part + 60 * (3 * part**2 - 2 * part**3)], axis=1)


def bar(share: float) -> Floats:
    """A bar of 16 x 36 px at the upper right, with this share of the object's light."""
    image = np.zeros((128, 128))
    image[12:48, 80:96] = share * float(letter_b().sum()) / (16 * 36)
    return image


@cache
def recorded(share: float, *, sigma: float = 0.1, seed: int = 1, scheme: str = "fourier-hadamard") -> Recording:
    """Object and bar, each pattern at its own time, and noise of sigma on every lit pixel, 8,192 of them."""
    plan: Plan = plan_of(scheme, FRAMES)
    recording = simulate(plan, letter_b(), path)
    if share:
        recording.values[:] += simulate(plan, bar(share), lambda time_s: np.zeros((len(time_s), 2))).values
    noise = np.random.default_rng(seed).standard_normal(recording.values.shape)
    recording.values[:] += sigma * np.sqrt(8192) * noise
    return recording
