"""Recordings of finite values that no working bench gives."""

from dataclasses import replace

import numpy as np

from instrument.recording import Recording
from protocols import Floats

KINDS = (
    "constant",
    "zero",
    "negative",
    "huge",
    "tiny",
    "shifted",
    "exchanged",
    "complemented",
    "spikes",
    "noise",
    "few levels",
    "one frame lit",
    "one column",
    "step",
)
"""What was done to the values."""


def spoiled(recording: Recording, kind: str, random: np.random.Generator) -> Recording:
    """Give the recording with values of this kind, of 40 frames or more."""
    frames = int(random.integers(40, len(recording) + 1))
    cut = recording.first(frames)
    return replace(
        cut, values=_values(cut.values.astype(np.float64), kind, random), photon_counts=random.random() < 0.5
    )


def _values(values: Floats, kind: str, random: np.random.Generator) -> Floats:
    flat = values.ravel().copy()
    match kind:
        case "constant":
            return np.full_like(values, 10 ** random.uniform(-3, 9))
        case "zero":
            return np.zeros_like(values)
        case "negative":
            return -values
        case "huge":
            return values * 10 ** random.uniform(10, 300)
        case "tiny":
            return values * 10 ** random.uniform(-300, -10)
        case "shifted":
            return np.roll(flat, int(random.integers(-6, 7))).reshape(values.shape)
        case "exchanged":
            return values[:, random.permutation(values.shape[1])]
        case "complemented":
            return float(values.max()) - values
        case "spikes":
            flat[random.integers(0, flat.size, 5)] *= 100
            return flat.reshape(values.shape)
        case "noise":
            return np.abs(random.normal(1, random.uniform(0, 2), values.shape))
        case "few levels":
            return random.integers(0, 3, values.shape).astype(np.float64)
        case "one frame lit":
            return np.where(np.arange(len(values))[:, None] == int(random.integers(len(values))), values, 0.0)
        case "one column":
            kept: Floats = np.zeros(values.shape)
            column = int(random.integers(len(values[0])))
            kept[:, column] = values[:, column]
            return kept
        case "step":
            later = np.arange(len(values)) >= len(values) // 2
            return values * (1 + 999 * later[:, None].astype(np.float64))
        case _:
            raise ValueError(f"no such kind: {kind}")
