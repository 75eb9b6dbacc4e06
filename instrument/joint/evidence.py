"""What the values of every frame say of the object's displacement, given an image of it.

Each kind of value is compared with what the image predicts where the object is taken to be. The comparison gives a residual, and
the derivative of the prediction by the displacement, both in units of the noise: what a Gauss-Newton step needs.
"""

from dataclasses import dataclass

import numpy as np

from instrument.measurement import ImageValues
from instrument.reconstruction import FixedPatterns, Problem, walsh_rows
from instrument.schemes import PositionReading, position_of
from protocols import Floats, Integers, Singles

_LEAST_VARIANCE = 0.02  # over the mean variance: a dark frame of photon counts is not without noise
_TINY = 1e-12


@dataclass(frozen=True, eq=False)
class View:
    """What one kind of value says of the displacement, in units of its noise. Arrays begin with ``rows``, the valid frames."""

    residual: Floats
    """``(rows,)``: measured minus predicted value."""

    slope: Floats
    """``(rows, 2)``: derivative of the predicted value by x and y, 1/px."""


@dataclass(frozen=True, eq=False)
class AxisView:
    """What the position patterns of one axis say."""

    position: View
    """The combination of their values that a motion along the axis changes."""

    amplitude: Floats | None
    """``(rows,)``: residual of the combination at right angles to it, which no motion changes, in units of its noise; None where
    the axis has one pattern only."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """All that the values of a run say of the displacement, given an image."""

    x: AxisView
    """Position patterns along x."""

    y: AxisView
    """Position patterns along y."""

    hadamard: View
    """The difference I_H+ - I_H-."""

    @property
    def axes(self) -> tuple[AxisView, AxisView]:
        """Position patterns by axis."""
        return self.x, self.y

    @property
    def views(self) -> tuple[View, View, View]:
        """All kinds of values."""
        return self.x.position, self.y.position, self.hadamard


@dataclass(frozen=True, eq=False)
class _Prediction:
    """Values that an image gives for the k position patterns."""

    values: Floats
    """``(rows, k)``."""

    slopes: Floats
    """``(rows, k, 2)``: derivatives by x and y, per px."""

    variance: Floats
    """``(rows, k)``: variance of the measured values if they are as predicted."""


def evidence_of(problem: Problem, fixed: FixedPatterns, total: Floats, image: Singles) -> Evidence:
    """Compare the measured values with those that an image predicts where the object is taken to be.

    Only the direction in which motion changes an axis's position values counts, not their amplitude, so that an image that is
    too smooth or too dark is not mistaken for a motion.

    Args:
        problem: values, and the displacement of the object.
        fixed: position patterns, prepared for all displacements.
        total: ``(rows,)`` total light, smoothed over frames.
        image: ``(height, width)`` of the problem's region.
    """
    reading = position_of(problem.scheme)
    prediction = _predict(problem, fixed, reading, total, image)
    x, y = (_axis_view(axis, problem, reading, prediction, total) for axis in range(2))
    return Evidence(x, y, _hadamard_view(problem, image))


def _predict(
    problem: Problem, fixed: FixedPatterns, reading: PositionReading, total: Floats, image: Singles
) -> _Prediction:
    """Predict the values of the position patterns.

    Light that the image lacks, ``total`` less its own, does not stem from motion. It is taken to be spread over the field, where
    half of the mirrors of a Fourier pattern let it through. Moment patterns have no such share: there the light that is lacking
    is taken to lie where the image does.
    """
    place_px = problem.places.fixed
    predicted, slopes = fixed.values(fixed.maps(image), place_px)
    all_one = FixedPatterns(np.ones_like(fixed.patterns[:1]), fixed.region, fixed.width)
    own_light, _ = all_one.values(all_one.maps(image), place_px.mean(axis=1, keepdims=True))
    if reading.period_px is None:
        scale = total[:, None] / np.maximum(own_light, _TINY)
        predicted, slopes = predicted * scale, slopes * scale[..., None]
    else:
        predicted += (total[:, None] - own_light) / 2
    return _Prediction(predicted, slopes, _predicted_variance(problem.values, predicted))


def _predicted_variance(values: ImageValues, predicted: Floats) -> Floats:
    """Give the variance that the position values, ``(rows, k)``, have if they are as predicted.

    Photon counts get it from the regression of the measured values' variances on these values. Weighting each count by its own
    variance would favour low counts, which where there are few of them biases the motion by more than its noise.
    """
    measured, variance = values.fixed, values.fixed_variance
    if not values.photon_counts:
        return variance
    mean = float(measured.mean())
    deviation: Floats = measured - mean
    slope = float(np.vdot(deviation, variance) / (np.vdot(deviation, deviation) + _TINY))
    mean_variance = float(variance.mean())
    regression: Floats = mean_variance + slope * (predicted - mean)
    return np.maximum(regression, mean_variance * _LEAST_VARIANCE)


def _axis_view(
    axis: int, problem: Problem, reading: PositionReading, prediction: _Prediction, total: Floats
) -> AxisView:
    """Project the values of an axis on the direction of motion, and on the one at right angles to it."""
    columns: Integers = np.asarray(np.searchsorted(np.unique(reading.columns), reading.columns[axis]), np.int64)
    predicted, slopes, variance = (
        part[:, columns] for part in (prediction.values, prediction.slopes, prediction.variance)
    )
    residual = problem.values.fixed[:, columns] - predicted

    along = _unit(slopes[:, :, axis])
    sigma: Floats = np.sqrt(np.sum(along**2 * variance, axis=1))
    slope = np.einsum("rk,rka->ra", along, slopes) / sigma[:, None]
    position = View(np.sum(along * residual, axis=1) / sigma, slope)

    radial = _radial_direction(reading, axis, predicted, total)
    if radial is None:
        return AxisView(position, None)
    across = _unit(radial - np.vecdot(radial, along)[:, None] * along)
    across_sigma: Floats = np.sqrt(np.sum(across**2 * variance, axis=1)) + _TINY
    return AxisView(position, np.sum(across * residual, axis=1) / across_sigma)


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


def _hadamard_view(problem: Problem, image: Singles) -> View:
    """Compare the Hadamard differences, both patterns of a pair taken at the mean of their displacements.

    With y and x the two Walsh rows of a pattern as the moved object sees them, the difference is y' image x.
    """
    values, region = problem.values, problem.region
    x_px, y_px = ((problem.places.positive + problem.places.negative) / 2).T

    def rows_and_slopes(number: int, place_px: Floats, first_px: int, count: int) -> tuple[Singles, Singles]:
        """Give one factor of each pattern, and its derivative by the displacement."""
        walsh = values.pairs[:, number]
        rows = walsh_rows(values.size, walsh, place_px, first_px, count)
        return rows, walsh_rows(values.size, walsh, place_px, first_px, count, slope=True)

    y_rows, y_slopes = rows_and_slopes(0, y_px, region.top, region.height)
    x_rows, x_slopes = rows_and_slopes(1, x_px, region.left, region.width)
    columns = y_rows @ image
    by_x: Floats = np.vecdot(columns, x_slopes)
    by_y: Floats = np.vecdot(y_slopes @ image, x_rows)
    sigma = values.difference_sigma
    residual = (values.difference - np.vecdot(columns, x_rows)) / sigma
    return View(residual, np.stack([by_x, by_y], axis=-1) / sigma[:, None])
