"""What the values of every frame say of the object's displacement, given a prediction of them.

Each kind of value is compared with what the images predict where the object is taken to be. The comparison gives a residual, and
the derivative of the prediction by the displacement, both in units of the noise: what a Gauss-Newton step needs.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from instrument.joint.prediction import Prediction
from instrument.reconstruction import Problem
from instrument.schemes import PositionReading, position_of
from protocols import Floats, Integers

_TINY: Final = 1e-12

_OF_IMAGE: Final = 0.2
"""Error of the fringes' signal, over its rms, that the image of few patterns makes: not more than that is a contradiction,"""

_OF_COARSE: Final = 0.3
"""and how much more it may be where none of the patterns was seen that are as coarse as a fringe: a run whose first frames were
masked. Images of such runs were off by 0.26 where a third was not seen, and by 0.42 to 0.7 where none was."""

CONTRADICTS: Final = 1.5
"""Misfit of the position values above which they and the image contradict each other, whatever else may be."""


@dataclass(frozen=True, eq=False)
class View:
    """What one kind of value says of the displacement, in units of its noise. Arrays begin with ``rows``, the valid frames."""

    residual: Floats
    """``(rows,)``: measured minus predicted value."""

    slope: Floats
    """``(rows, 2)``: derivative of the predicted value by x and y, 1/px. That of the Hadamard values has two columns more where
    the object's shape changes: by angle and logarithm of the magnification."""


@dataclass(frozen=True, eq=False)
class Directions:
    """Combinations of an axis's k position values, each ``(rows, k)`` and divided by its own noise."""

    columns: Integers
    """``(k,)``: which of all position values they combine."""

    along: Floats
    """The combination that a motion along the axis changes."""

    across: Floats | None
    """The one at right angles to it, which no motion changes: the signal's amplitude. None where the axis has one pattern."""


@dataclass(frozen=True, eq=False)
class AxisView:
    """What the position patterns of one axis say."""

    position: View
    """The combination of their values that a motion along the axis changes."""

    by_offset: Floats
    """``(rows, k)``: derivative of that combination by the offset of each of all position values."""

    amplitude: Floats | None
    """``(rows,)``: residual of the combination at right angles to it, which no motion changes, in units of its noise; None where
    the axis has one pattern only."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """All that the values of a run say of the displacement, given a prediction."""

    x: AxisView
    """Position patterns along x."""

    y: AxisView
    """Position patterns along y."""

    hadamard: View
    """The difference I_H+ - I_H-."""

    misfit: float
    """Root mean square of what is left of the position values, over their noise, of the position pattern where it is largest:
    about 1 where these values are of the object that the image shows, on the path that it is shown on."""

    total: View | None = None
    """The total light of an object that passes by, and loses and gains light at the border; None where it stays inside."""

    @property
    def axes(self) -> tuple[AxisView, AxisView]:
        """Position patterns by axis."""
        return self.x, self.y

    @property
    def views(self) -> tuple[View, ...]:
        """All kinds of values."""
        views = self.x.position, self.y.position, self.hadamard
        return views if self.total is None else (*views, self.total)


def evidence_of(problem: Problem, prediction: Prediction, offset: Floats) -> Evidence:
    """Compare the measured values with the predicted ones.

    Only the direction in which motion changes an axis's position values counts, not their amplitude, so that an image that is
    too smooth or too dark is not mistaken for a motion.

    Args:
        problem: values measured.
        prediction: what they are compared with.
        offset: ``(k,)`` share of the total light that each position value has beyond the prediction.
    """
    residual = problem.values.fixed - prediction.values - prediction.total[:, None] * offset
    x, y = (_axis_view(directions_of(problem, prediction, axis), prediction, residual) for axis in range(2))
    sigma = problem.values.difference_sigma
    of_difference = (problem.values.difference - prediction.difference) / sigma
    signal = prediction.values - prediction.total[:, None] / 2
    of_image = _OF_IMAGE + _OF_COARSE * _unseen(problem)
    allowed = prediction.variance + of_image**2 * np.mean(signal**2, axis=1, keepdims=True) + _TINY
    misfit = float(np.sqrt(np.mean(residual**2 / allowed, axis=0).max()))
    total = None
    if problem.passes:
        missing = problem.values.positive + problem.values.negative - prediction.light
        total = View(missing / sigma, prediction.light_slopes / sigma[:, None])
    return Evidence(x, y, View(of_difference, prediction.difference_slopes / sigma[:, None]), misfit, total)


def _unseen(problem: Problem) -> float:
    """Give the share of the Hadamard patterns as coarse as a fringe that no frame shows; 0 where there is no fringe."""
    period_px = position_of(problem.scheme).period_px
    if period_px is None:
        return 0.0
    count = round(2 * problem.values.size / period_px)
    pairs = problem.values.pairs
    coarse = pairs[(pairs < count).all(axis=1)]
    return 1 - len(np.unique(coarse, axis=0)) / count**2


def directions_of(problem: Problem, prediction: Prediction, axis: int) -> Directions:
    """Find the direction of motion of an axis's position values, and the one at right angles to it.

    Args:
        problem: values measured.
        prediction: values where the object is taken to be.
        axis: 0 for x, 1 for y.
    """
    reading = position_of(problem.scheme)
    columns: Integers = np.asarray(np.searchsorted(np.unique(reading.columns), reading.columns[axis]), np.int64)
    variance = prediction.variance[:, columns]
    along = _unit(prediction.slopes[:, columns, axis])
    sigma: Floats = np.sqrt(np.sum(along**2 * variance, axis=1)) + _TINY  # where the object is outside, all is 0
    radial = _radial_direction(reading, axis, prediction.values[:, columns], prediction.total)
    if radial is None:
        return Directions(columns, along / sigma[:, None], None)
    across = _unit(radial - np.vecdot(radial, along)[:, None] * along)
    across_sigma: Floats = np.sqrt(np.sum(across**2 * variance, axis=1)) + _TINY
    return Directions(columns, along / sigma[:, None], across / across_sigma[:, None])


def _axis_view(directions: Directions, prediction: Prediction, residual: Floats) -> AxisView:
    """Project the residuals, ``(rows, k)``, on the direction of motion, and on the one at right angles to it."""
    own = residual[:, directions.columns]
    slope = np.einsum("rk,rka->ra", directions.along, prediction.slopes[:, directions.columns])
    position = View(np.sum(directions.along * own, axis=1), slope)
    by_offset = np.zeros_like(residual)
    by_offset[:, directions.columns] = prediction.total[:, None] * directions.along
    amplitude = None if directions.across is None else np.sum(directions.across * own, axis=1)
    return AxisView(position, by_offset, amplitude)


def _radial_direction(reading: PositionReading, axis: int, predicted: Floats, total: Floats) -> Floats | None:
    """Give the change, ``(rows, k)``, of an axis's values with the amplitude of their signal; None where it has none."""
    if reading.period_px is None:
        return None
    shares = predicted / np.maximum(total, _TINY)[:, None]
    signal = np.einsum("pk,rk->rp", reading.weights[axis], shares) + reading.offset[axis]
    return np.asarray(signal @ reading.response[axis].T, np.float64)


def _unit(vectors: Floats) -> Floats:
    """Give ``(rows, k)`` vectors the length 1, and leave those of length 0."""
    unit: Floats = vectors / (np.linalg.norm(vectors, axis=1)[:, None] + _TINY)
    return unit
