"""The values that images of object and background predict for every pattern of a run."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from instrument.measurement import ImageValues
from instrument.numerics import smooth
from instrument.reconstruction import FixedPatterns, Problem, hadamard_values, walsh_rows
from instrument.schemes import PositionReading, position_of
from protocols import Floats, Singles

_LEAST_VARIANCE = 0.02  # over the mean variance: a dark frame of photon counts is not without noise
_TINY = 1e-12


@dataclass(frozen=True, eq=False)
class Prediction:
    """Values that images give, at the places where the object is taken to be. Arrays begin with ``rows``, the valid frames."""

    total: Floats
    """``(rows,)``: total light I_H+ + I_H-, smoothed over frames."""

    values: Floats
    """``(rows, k)``: values of the k position patterns."""

    slopes: Floats
    """``(rows, k, 2)``: their derivatives by x and y, per px."""

    variance: Floats
    """``(rows, k)``: variance of the measured values if they are as predicted."""

    light: Floats
    """``(rows,)``: total light of the images themselves, where they are."""

    light_slopes: Floats
    """``(rows, 2)``: its derivatives by x and y, per px."""

    bordering: Floats
    """``(rows, k)``: light of lit pixels times the number of sides at which they border dark ones: minus the derivative of
    ``values`` by the edge loss a side."""

    difference: Floats
    """``(rows,)``: differences I_H+ - I_H-."""

    difference_slopes: Floats
    """``(rows, 2)``: their derivatives by x and y, per px; ``(rows, 4)`` where the object's shape changes, by angle and logarithm
    of the magnification too: at the same light where the values were divided by it."""


@dataclass(frozen=True, eq=False)
class Predictor:
    """What predictions of one run have in common."""

    reading: PositionReading
    """How position values become a position."""

    fixed: FixedPatterns
    """The position patterns as they act."""

    borders: FixedPatterns
    """Their lit pixels, each times the number of its sides that border dark ones."""

    all_on: FixedPatterns
    """The pattern that lets all light through."""

    @classmethod
    def of(cls, problem: Problem) -> Self:
        """Prepare the patterns of a problem, for any displacement."""
        fixed = problem.fixed_patterns()
        return cls(position_of(problem.scheme), fixed, problem.fixed_borders(), problem.all_light())

    def of_field(self, problem: Problem) -> "Predictor":
        """Give the predictor of the same patterns with the edge loss of another problem."""
        if problem.field == self.fixed.field:
            return self
        return replace(self, fixed=problem.fixed_patterns())

    def predict(self, problem: Problem, image: Singles, still: Singles | None) -> Prediction:
        """Predict the values of a run.

        Light that the images lack, the total less their own, does not stem from motion. It is taken to be spread over the field,
        where half of the mirrors of a Fourier pattern let it through. Moment patterns have no such share: there the light that
        is lacking is taken to lie where the image does.

        Args:
            problem: values, and the displacement of the object.
            image: image of the object, of the problem's region.
            still: ``(size, size)`` image of what stands still; None for nothing.
        """
        total = _steady_total(problem.values)
        values, slopes = problem.fixed_values(self.fixed, image)
        bordering, _ = problem.fixed_values(self.borders, image)
        own_light, own_slopes = problem.total_light(self.all_on, image)
        own_light = own_light[:, None]
        difference, difference_slopes = _differences(problem, image)
        if still is not None:
            values = values + problem.of_still(still)
            own_light = own_light + float(still.sum(dtype=np.float64))
            difference = difference + hadamard_values(replace(problem.field, grid=1), still, problem.values.pairs)
        if problem.steady:
            difference_slopes[:, 3:] -= 2 * difference[:, None]
        if self.reading.period_px is None:
            scale = total[:, None] / np.maximum(own_light, _TINY)
            values, slopes = values * scale, slopes * scale[..., None]
        else:
            values = values + (total[:, None] - own_light) / 2
            if not problem.steady:  # it loses light at the border of the field
                slopes = slopes - own_slopes[:, None] / 2
        variance = _predicted_variance(problem.values, values)
        light = own_light[:, 0]
        return Prediction(total, values, slopes, variance, light, own_slopes, bordering, difference, difference_slopes)


def _steady_total(values: ImageValues) -> Floats:
    """Give the total light I_H+ + I_H-, ``(rows,)``, smoothed over frames."""
    total: Floats = values.positive + values.negative
    return smooth(total, np.ones(len(total)), orders=(1,)).values


def _predicted_variance(values: ImageValues, predicted: Floats) -> Floats:
    """Give the variance that the position values, ``(rows, k)``, have if they are as predicted.

    Photon counts get it from the regression of the measured values' variances on these values, each divided by that of its pair,
    which is larger where the lamp was darker and its light was scaled up. Weighting each count by its own
    variance would favour low counts, which where there are few of them biases the motion by more than its noise.
    """
    measured, variance = values.fixed, values.fixed_variance
    if not values.photon_counts:
        return variance
    darker: Floats = (values.difference_variance / float(np.median(values.difference_variance)))[:, None]
    of_lamp = variance / darker
    mean = float(measured.mean())
    deviation: Floats = measured - mean
    slope = float(np.vdot(deviation, of_lamp) / (np.vdot(deviation, deviation) + _TINY))
    mean_variance = float(of_lamp.mean())
    regression: Floats = mean_variance + slope * (predicted - mean)
    return np.maximum(regression, mean_variance * _LEAST_VARIANCE) * darker


def _differences(problem: Problem, image: Singles) -> tuple[Floats, Floats]:
    """Give the Hadamard differences and their slopes, both patterns of a pair taken at the mean of their displacements.

    With y and x the two Walsh rows of a pattern as the moved object sees them, the difference is y' image x. How the
    brightness of the field changes with the displacement counts for nothing beside that.
    """
    brightness = problem.brightness()
    if brightness is None:
        return _evenly_lit(problem, image)
    terms = [
        (of_rows, *_evenly_lit(problem, of_pixels * image))
        for of_rows, of_pixels in zip(brightness.of_rows, brightness.of_pixels, strict=True)
    ]
    difference = sum((of_rows * own for of_rows, own, _ in terms), start=np.zeros(len(problem.values)))
    slopes = sum((of_rows[:, None] * own for of_rows, _, own in terms), start=np.zeros_like(terms[0][2]))
    return difference, slopes


def _evenly_lit(problem: Problem, image: Singles) -> tuple[Floats, Floats]:
    """Give the same in a field that is lit evenly."""
    if problem.places.shape is not None:
        return problem.turned_rows().values(image)
    values, region, field = problem.values, problem.region, problem.field
    x_px, y_px = ((problem.places.positive + problem.places.negative) / 2).T

    def rows_and_slopes(number: int, place_px: Floats, first_px: int, count_px: int) -> tuple[Singles, Singles]:
        """Give one factor of each pattern, and its derivative by the displacement."""
        walsh = values.pairs[:, number]
        rows = walsh_rows(field, walsh, place_px, first_px, count_px)
        return rows, walsh_rows(field, walsh, place_px, first_px, count_px, slope=True)

    y_rows, y_slopes = rows_and_slopes(0, y_px, region.top, region.height)
    x_rows, x_slopes = rows_and_slopes(1, x_px, region.left, region.width)
    columns = y_rows @ image
    by_x: Floats = np.vecdot(columns, x_slopes).astype(np.float64)
    by_y: Floats = np.vecdot(y_slopes @ image, x_rows).astype(np.float64)
    return np.vecdot(columns, x_rows).astype(np.float64), np.stack([by_x, by_y], axis=-1)
