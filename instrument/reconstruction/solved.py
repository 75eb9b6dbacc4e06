"""The image of a problem by total variation."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, TypedDict, Unpack

import numpy as np

from instrument.numerics import EIGENVALUE_MARGIN, Operator, TvState, largest_eigenvalue, total_variation
from instrument.reconstruction.problem import Problem

_PASSING: Final = (0.002, 1000)
"""Tolerance and iterations of a cold start for an object that passes by: its coarse parts come slowly."""


class Steps(TypedDict, total=False):
    """Options of ``total_variation``."""

    strength: float
    reweightings: int | None
    bregman_steps: int
    tolerance: float
    iterations: int
    start: TvState | None


def solved(problem: Problem, **steps: Unpack[Steps]) -> TvState:
    """Solve a problem by total variation, from all its rows.

    Args:
        problem: the problem.
        steps: as in ``total_variation``.

    Returns:
        Images and misfit, that of the Hadamard differences.
    """
    finer: Sequence[int] = problem.finer
    if not problem.passes:
        return total_variation(*problem.hadamard(), finer=finer, **steps)
    if steps.get("start") is None and "tolerance" not in steps:
        steps["tolerance"], steps["iterations"] = _PASSING
    every = problem.rows()
    start = steps.get("start")
    if start is not None:  # what is in the field has changed with the path, and with it how strongly an image is seen
        steps["start"] = _seen_by(every[0], start)
    state = total_variation(*every, finer=finer, **steps)
    images = np.concatenate([image.ravel() for image in state.images])
    left = (every[1] - every[0].matvec(images))[: len(problem.values)]  # of the Hadamard differences, which come first
    return replace(state, misfit=float(np.sqrt(np.mean(np.square(left, dtype=np.float64)))))


def _seen_by(rows: Operator, state: TvState) -> TvState:
    """Give a start from images that were found by other rows."""
    eigenvalue = largest_eigenvalue(rows) * EIGENVALUE_MARGIN
    factor = np.float32(state.eigenvalue / max(eigenvalue, 1e-30))
    return replace(state, eigenvalue=eigenvalue, duals=tuple(dual * factor for dual in state.duals))
