"""The values that path and image expect of every frame, also of those whose own nobody knows or believes."""

from dataclasses import dataclass, replace
from typing import Final, Self

import numpy as np

from instrument.joint.evidence import evidence_of
from instrument.joint.prediction import Predictor
from instrument.joint.rounds import USUAL
from instrument.measurement import Measurement, first_light, fixed_columns
from instrument.numerics import one_blas_thread, smooth, total_variation
from instrument.reconstruction import Problem, Reconstruction
from instrument.schemes import image_rows_of
from instrument.tracking import Trajectory, track
from protocols import Floats, Integers, Mask, Singles

_ITERATIONS: Final = 40


@dataclass(frozen=True, eq=False)
class Explained:
    """Path and image that explain a run, as far as they do."""

    measurement: Measurement
    """The run, its light found."""

    problem: Problem
    """The image problem of its valid frames."""

    trajectory: Trajectory
    """The path."""

    image: Singles
    """Image of the object, of the problem's region."""

    still: Singles | None = None
    """``(size, size)``: image of what stands still; None for nothing."""

    @classmethod
    def at_first_sight(cls, measurement: Measurement, trajectory: Trajectory) -> Self:
        """Make one image along a path as it is.

        Raises:
            InputError: the displacements leave no room for an object in the field.
        """
        problem = Problem.of(measurement, measurement.image_values(steady_object=True), trajectory, region="inside")
        state = total_variation(
            *problem.hadamard(),
            strength=USUAL,
            finer=problem.finer,
            tolerance=0.03,
            iterations=_ITERATIONS,
            reweightings=0,
        )
        return cls(measurement, problem, trajectory, state.image)

    @classmethod
    def of(cls, measurement: Measurement, trajectory: Trajectory, found: Reconstruction) -> Self:
        """Take the image that was found."""
        values, grid, region = measurement.image_values(steady_object=True), found.grid, found.region
        problem = Problem.of(measurement, values, trajectory, region="inside", grid=grid, still=found.still is not None)
        rows, columns = slice(region.top, region.top + region.height), slice(region.left, region.left + region.width)
        image = found.image[rows.start * grid : rows.stop * grid, columns.start * grid : columns.stop * grid]
        still = None if found.still is None else (found.still * found.gain).astype(np.float32)
        return cls(measurement, problem.within(region), trajectory, (image * found.gain).astype(np.float32), still)

    def misfit(self) -> float:
        """Give the misfit of the position values, as ``Refined.position_misfit`` says."""
        prediction = Predictor.of(self.problem).predict(self.problem, self.image, self.still)
        return evidence_of(self.problem, prediction, np.zeros(len(prediction.values.T))).misfit

    def path_freedom(self) -> float:
        """Give how many numbers the path takes from the position values: the variance of each place over that of one frame's.

        A path that jumps is smoothed less than one that does not, and follows the noise of all frames.
        """
        frame = self.problem.values.frame
        prediction = Predictor.of(self.problem).predict(self.problem, self.image, self.still)
        information = np.sum(prediction.slopes**2 / prediction.variance[..., None], axis=1)
        variance_px2 = (
            self.trajectory.sigma_px[frame] ** 2 / 2
        )  # of a place and of the first one, to which it is relative
        return float(np.sum(variance_px2 * information))

    def values(self) -> Floats:
        """``(frames, patterns_per_frame)``: what all frames are expected to give, in the lamp's light as it was."""
        measurement, problem = _whole(self.measurement), self.problem
        values = measurement.image_values(steady_object=problem.steady)
        every = replace(problem, values=values, seen=None).moved(self.trajectory).seen_as(self.image, self.still)
        prediction = Predictor.of(every).predict(every, self.image, self.still)
        rows = image_rows_of(measurement.scheme)
        expected = np.full(measurement.values.shape, np.nan)
        expected[:, fixed_columns(measurement.scheme)] = prediction.values
        expected[:, rows.positive] = (prediction.total + prediction.difference) / 2
        expected[:, rows.negative] = (prediction.total - prediction.difference) / 2
        total: Floats = measurement.values[:, rows.positive] + measurement.values[:, rows.negative]
        lamp = smooth(total, np.ones(len(total)), orders=(1,)).values / prediction.total
        expected *= lamp[:, None]
        return _on_average(expected, self.measurement.values, self.measurement.valid)


@one_blas_thread()
def at_first_sight(measurement: Measurement) -> Explained:
    """Find light, path and image of a run, each once and not yet refined.

    Raises:
        InputError: there is no path, or it leaves no room for an object in the field.
    """
    lit = first_light(measurement)
    return Explained.at_first_sight(lit, track(lit))


def _whole(measurement: Measurement) -> Measurement:
    """Give the run with values between those beside in place of those that are not valid."""
    every = np.full(len(measurement), fill_value=True)
    values, variance = (_filled(of, measurement.valid) for of in (measurement.values, measurement.variance))
    return replace(measurement, values=values, variance=variance, valid=every)


def _filled(series: Floats, valid: Mask) -> Floats:
    index: Integers = np.arange(len(series), dtype=np.int64)
    filled = np.empty_like(series)
    for column in range(series.shape[1]):
        filled[:, column] = np.interp(index, index[valid], series[valid, column])
    return filled


def _on_average(expected: Floats, values: Floats, valid: Mask) -> Floats:
    """Scale and shift each column as its values say: an image may be too smooth, and light that stands still was in none."""
    mean, measured = expected[valid].mean(axis=0), values[valid].mean(axis=0)
    deviation: Floats = expected - mean
    power = np.sum(deviation[valid] ** 2, axis=0)
    slope = np.sum(deviation[valid] * (values[valid] - measured), axis=0) / np.maximum(power, 1e-300)
    return np.asarray(measured + slope * deviation, np.float64)
