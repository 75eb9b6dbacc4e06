"""A short run of a 64 px object, computed from formulas, and its values as a stream of blocks."""

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np

from instrument.acquisition import AlignedBlock
from instrument.plan import Plan
from instrument.recording import Recording
from protocols import Floats
from tests.support.simulation import simulate

SIZE = 64
FRAMES = 600
PLAN = Plan(frames=FRAMES, image_size=SIZE)
_NONE = np.zeros(0, np.int64)


def letter() -> Floats:
    """A square with a hole, 0.6 beside 1; 434 px of light."""
    image = np.zeros((SIZE, SIZE))
    image[8:26, 10:28] = 1.0
    image[13:20, 15:22] = 0.0
    image[8:26, 28:34] = 0.6
    return image


def drift(time_s: Floats) -> Floats:
    """21.6 px right and 32.4 px down in a run of 0.18 s, on a curve."""
    return np.stack([120 * time_s, 180 * time_s + 500 * time_s * (time_s - 0.18)], axis=1)


@lru_cache
def run(sigma: float = 0.05) -> Recording:
    """The run, seed 1."""
    return simulate(PLAN, letter(), drift, sigma=sigma, seed=1)


def block(first_pattern: int, values: Floats) -> AlignedBlock:
    """A block in which all is well."""
    return AlignedBlock(first_pattern, values, np.isfinite(values), None, _NONE, _NONE, _NONE)


def blocks(values: Floats, sizes: Sequence[int]) -> Iterator[AlignedBlock]:
    """A stream cut into blocks of these sizes, again and again."""
    flat = values.ravel()
    first = turn = 0
    while first < len(flat):
        size = sizes[turn % len(sizes)]
        yield block(first, flat[first : first + size])
        first, turn = first + size, turn + 1


def psnr(image: Floats, truth: Floats) -> float:
    """Peak 1, clipped."""
    return float(-10 * np.log10(np.mean((np.clip(image, 0, 1) - truth) ** 2)))
