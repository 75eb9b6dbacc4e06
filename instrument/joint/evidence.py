"""What every frame says of the object's displacement, given an image of it: residuals and slopes of all its values."""

from dataclasses import dataclass

import numpy as np

from instrument.measurement import ImageValues
from instrument.reconstruction import FixedPatterns, Problem, walsh_rows
from instrument.schemes import PositionReading, position_of
from protocols import Floats, Singles

_LEAST_VARIANCE = 0.02  # of the mean: dark frames of photon counts are not certain
_TINY = 1e-12


@dataclass(frozen=True, eq=False)
class View:
    """What one kind of value says of the displacement, in units of its noise. Each array begins with the valid frames."""

    residual: Floats
    """``(rows,)``: measured minus predicted."""

    slope: Floats
    """``(rows, 2)``: derivative of the prediction by x and y, 1/px."""


@dataclass(frozen=True, eq=False)
class AxisView:
    """What the position patterns of one axis say."""

    position: View
    """The combination of their values that motion changes."""

    amplitude: Floats | None
    """``(rows,)``: what is left of them at right angles to motion, in units of its noise; None where one pattern is all."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """All that the values of a run say of the displacement, given an image."""

    axes: tuple[AxisView, AxisView]
    """Position patterns along x and along y."""

    hadamard: View
    """The Hadamard difference."""

    @property
    def views(self) -> tuple[View, View, View]:
        """Every view."""
        return self.axes[0].position, self.axes[1].position, self.hadamard


def evidence(problem: Problem, fixed: FixedPatterns, total: Floats, image: Singles) -> Evidence:
    """Compare measured values with those that an image gives where the object is taken to be.

    Of each axis's position values only the direction in which motion changes them counts, not their amplitude: an image too
    smooth or too dark is no motion.

    Args:
        problem: values, and the places of the object.
        fixed: its position patterns, for all displacements.
        total: ``(rows,)`` total light, smoothed over frames.
        image: ``(height, width)`` of the region.
    """
    reading = position_of(problem.scheme)
    expected, slope = _expected(problem, fixed, reading, total, image)
    residual = problem.values.fixed - expected
    variance = _expected_variance(problem.values, expected)
    columns = np.searchsorted(np.unique(reading.columns), reading.columns)
    x, y = (
        _axis_view(
            residual[:, own], slope[:, own], variance[:, own], axis, _radial(reading, axis, expected[:, own], total)
        )
        for axis, own in enumerate(columns)
    )
    return Evidence((x, y), _hadamard_view(problem, image))


def _expected(
    problem: Problem, fixed: FixedPatterns, reading: PositionReading, total: Floats, image: Singles
) -> tuple[Floats, Floats]:
    """Values that the image predicts for the position patterns, ``(rows, k)``, and their derivatives, ``(rows, k, 2)``.

    Light that the image lacks, ``total`` less its own, is no motion. Haze over the field is seen by half of the mirrors of a
    Fourier pattern; where there is no such share, as with moments, the lacking light is taken to be where the image is.
    """
    place_px = problem.places.fixed
    predicted, slope = fixed.values(fixed.maps(image), place_px)
    field = FixedPatterns(np.ones_like(fixed.patterns[:1]), fixed.region, fixed.width)
    lit, _ = field.values(field.maps(image), place_px.mean(axis=1, keepdims=True))
    if reading.period_px is None:
        scale = total[:, None] / np.maximum(lit, _TINY)
        return predicted * scale, slope * scale[..., None]
    return predicted + (total[:, None] - lit) / 2, slope


def _radial(reading: PositionReading, axis: int, expected: Floats, total: Floats) -> Floats | None:
    """``(rows, k)``: how the values of an axis change with the amplitude of their signal; None without an amplitude."""
    if reading.period_px is None:
        return None
    shares = expected / np.maximum(total, _TINY)[:, None]
    signal = np.einsum("pk,rk->rp", reading.weights[axis], shares) + reading.offset[axis]
    return np.asarray(signal @ reading.response[axis].T, np.float64)


def _axis_view(residual: Floats, slope: Floats, variance: Floats, axis: int, radial: Floats | None) -> AxisView:
    """Project the values of an axis, ``(rows, k)`` each, on the direction of motion, and on the one at right angles to it."""
    own = slope[:, :, axis]
    turn: Floats = own / (np.linalg.norm(own, axis=1)[:, None] + _TINY)
    sigma: Floats = np.sqrt(np.sum(turn**2 * variance, axis=1))
    position = View(np.sum(turn * residual, axis=1) / sigma, np.einsum("rk,rka->ra", turn, slope) / sigma[:, None])
    if radial is None:
        return AxisView(position, None)
    across = radial - np.vecdot(radial, turn)[:, None] * turn
    across /= np.linalg.norm(across, axis=1)[:, None] + _TINY
    aside: Floats = np.sqrt(np.sum(across**2 * variance, axis=1)) + _TINY
    return AxisView(position, np.sum(across * residual, axis=1) / aside)


def _expected_variance(values: ImageValues, expected: Floats) -> Floats:
    """Variance of the position values if they were as expected, from how those that came go with their variances.

    Weighting photon counts by those that came would favour low ones, and with few counts that is a bias of the motion larger
    than its noise.
    """
    came, variance = values.fixed, values.fixed_variance
    if not values.photon_counts:
        return variance
    spread: Floats = came - float(came.mean())
    slope = float(np.vdot(spread, variance) / (np.vdot(spread, spread) + _TINY))
    mean = float(variance.mean())
    line: Floats = mean + slope * (expected - float(came.mean()))
    return np.maximum(line, mean * _LEAST_VARIANCE)


def _hadamard_view(problem: Problem, image: Singles) -> View:
    """Residuals of the Hadamard differences, both patterns of a pair taken at the mean of their places, and their slopes."""
    values, region = problem.values, problem.region
    x_px, y_px = ((problem.places.positive + problem.places.negative) / 2).T
    down, down_slope = (
        walsh_rows(values.size, values.pairs[:, 0], y_px, region.top, region.height, slope=slope)
        for slope in (False, True)
    )
    across, across_slope = (
        walsh_rows(values.size, values.pairs[:, 1], x_px, region.left, region.width, slope=slope)
        for slope in (False, True)
    )
    columns = down @ image
    by_x: Floats = np.vecdot(columns, across_slope)
    by_y: Floats = np.vecdot(down_slope @ image, across)
    sigma = values.difference_sigma
    residual = (values.difference - np.vecdot(columns, across)) / sigma
    return View(residual, np.stack([by_x, by_y], axis=-1) / sigma[:, None])
