"""A frame that was lost as a whole: all values after it are of the Hadamard pattern after their own.

Its six values are gone, and neither the order of bright and dark patterns within a frame nor the path tell of it. The image does:
it is made of values that after the loss belong to other patterns. Were a frame lost, an image of the patterns as they were then
shown would explain the values better; where none was, it explains them far worse. A few iterations of the solver, from the image
that was found, tell the two apart, for a loss assumed at each of a few places. Only where one of them is not far worse is the
place looked for.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from instrument.measurement import cheapest_place
from instrument.numerics import TvState, total_variation
from instrument.reconstruction import METHODS, Problem
from instrument.schemes import image_rows_of
from protocols import Floats, Singles

_FEWEST_FRAMES: Final = 200
"""Frames below which nothing is concluded."""

_TRIED: Final = (1 / 16, 1 / 4, 1 / 2, 2 / 3)
"""Places of an assumed loss, over the run: a loss elsewhere is seen from the next of them."""

_FEW: Final = 6
"""Iterations after which it is clear whether an assumed loss is far worse."""

_FAR_WORSE: Final = 0.25
"""Rise of the sum of squares, over what the changed patterns change of the prediction, above which a loss is out of the question.
It was 0.26 to 0.97 in runs without a loss, and below 0.25 at one place at least in those with one in their first half."""

_PLACES: Final = (1 / 64, 1 / 32, 1 / 16, 1 / 8, 1 / 5, 0.3, 0.45, 0.6, 0.75)
"""Where the loss is looked for at first, over the run."""

_ITERATIONS: Final = 40

_SURE: Final = 10.0
"""Sum of squares by which another place of the loss is worse where it is out of the question."""


@dataclass(frozen=True)
class LostFrame:
    """Where a frame was lost."""

    frame: int
    """The frame whose values are gone, were they all in place: the first whose values are of the pattern after its own."""

    first: int
    """First frame that it may be."""

    last: int
    """Last frame that it may be."""


def lost_frame(problem: Problem, state: TvState) -> LostFrame | None:
    """Find a frame that was lost.

    Args:
        problem: values, and the path.
        state: the image of that problem.

    Returns:
        Where it was, if any was lost, which a path that is refined once more with the values moved back has to show; None where
        none was, or too few came after it to tell.
    """
    rows = image_rows_of(problem.scheme)
    count = len(problem.values)
    if count < _FEWEST_FRAMES or rows.ramps is not None:
        return None
    frame = problem.values.frame
    shown, after = rows.pairs[frame % len(rows.pairs)], rows.pairs[(frame + 1) % len(rows.pairs)]

    def lost_at(row: int) -> Problem:
        """State the problem of a loss before a row."""
        pairs = np.where((np.arange(count) >= row)[:, None], after, shown)
        return replace(problem, values=replace(problem.values, pairs=pairs))

    def solved(asked: Problem, start: TvState, iterations: int) -> TvState:
        return total_variation(
            *asked.hadamard(),
            strength=METHODS["tv"].strength or 0.0,
            finer=asked.finer,
            tolerance=0.03,
            iterations=iterations,
            start=start,
        )

    image = np.concatenate([part.ravel() for part in state.images])
    own = problem.hadamard()[0].matvec(image)
    if not any(_likely(lost_at(round(place * count)), own, image, state, solved) for place in _TRIED):
        return None
    tried = {row: solved(lost_at(row), state, _ITERATIONS) for row in (round(place * count) for place in _PLACES)}
    row = min(tried, key=lambda row: tried[row].misfit)
    best = tried[row]
    for _ in range(2):
        row = _place(problem, lost_at(0), best)[0]
        best = solved(lost_at(row), best, _ITERATIONS)
    row, low, high = _place(problem, lost_at(0), best)
    return LostFrame(*(int(frame[min(k, count - 1)]) for k in (row, low, high)))


def _likely(
    lost: Problem,
    own: Singles,
    image: Singles,
    state: TvState,
    solved: Callable[[Problem, TvState, int], TvState],
) -> bool:
    """Whether a loss does not explain the values far worse than none."""
    changed = float(np.sum((lost.hadamard()[0].matvec(image) - own) ** 2))
    rise = len(lost.values) * (solved(lost, state, _FEW).misfit ** 2 - state.misfit**2)
    return rise < _FAR_WORSE * changed


def _place(problem: Problem, lost: Problem, state: TvState) -> tuple[int, int, int]:
    """Give the row from which on an image explains the values better by the pattern after, and the first and last it may be.

    Args:
        problem: as planned.
        lost: with the pattern after in all rows.
        state: image of the run with the loss where it was taken to be.
    """
    image = np.concatenate([part.ravel() for part in state.images])
    cost: list[Floats] = []
    for asked in (problem, lost):
        operator, values = asked.hadamard()
        cost.append((values - operator.matvec(image)).astype(np.float64) ** 2)
    return cheapest_place(cost[0], cost[1], _SURE)
