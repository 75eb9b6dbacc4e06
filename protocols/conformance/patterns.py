"""Small sequences for any modulator."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from protocols.modulator import ModulatorLimits, ModulatorTiming, PatternSequence, PixelGrid

SAMPLES: Final = 8
"""Side of a pattern in samples."""


def sequence_for(
    limits: ModulatorLimits, n_patterns: int, *, unique: int | None = None, extra_columns: int = 0
) -> PatternSequence:
    """``n_patterns`` pictures and the dark guard picture on this modulator's mirrors.

    Args:
        limits: of the modulator.
        n_patterns: pictures without the guard.
        unique: planes in memory, the dark one included; None: one for each picture, and the dark one.
        extra_columns: by how much the geometry shall be wrong.
    """
    planes = np.zeros((n_patterns + 1 if unique is None else unique, SAMPLES, 1), np.uint8)
    numbers = np.arange(len(planes))
    for row in range(4):
        planes[:, row, 0] = numbers >> 8 * row  # plane k shows the number k, plane 0 is dark
    lit = 1 + np.arange(n_patterns) % (len(planes) - 1)
    grid = PixelGrid(
        image_size=SAMPLES,
        superpixel=min(limits.rows, limits.columns) // SAMPLES,
        columns=limits.columns + extra_columns,
        rows=limits.rows,
    )
    return PatternSequence(planes, np.append(lit, 0), grid, SAMPLES)


def timing_for(limits: ModulatorLimits, picture_time_us: int = 10_000) -> ModulatorTiming:
    """Pictures of 10 ms, or as near as the modulator can."""
    fitting_us = min(max(picture_time_us, limits.shortest_picture_time_us), limits.longest_picture_time_us)
    return ModulatorTiming(picture_time_us=fitting_us)


def run_s(sequence: PatternSequence, timing: ModulatorTiming) -> float:
    """Give the time that a sequence plays, its guard picture included, in seconds."""
    return len(sequence.play_order) * timing.picture_time_us * 1e-6


def steps(values: Sequence[int], last: int) -> bool:
    """Whether ``values`` rise from 1 or more to ``last``."""
    return bool(values) and values[-1] == last and all(a < b for a, b in pairwise(values))
