"""Joint refinement: motion from all values against the current image, the image again with that motion, until both stand."""

from dataclasses import dataclass

import numpy as np

from instrument.reconstruction.correlation import FixedPatterns
from instrument.reconstruction.reconstruct import Reconstruction, finished
from instrument.reconstruction.region import Region
from instrument.reconstruction.rows import NEGATIVE, POSITIVE, Measurement, as_trajectory, places_px
from instrument.reconstruction.tv import total_variation
from instrument.reconstruction.walsh_rows import walsh_rows
from instrument.recording import Recording
from instrument.schemes import scheme_of
from instrument.threads import one_blas_thread
from instrument.tracking import Trajectory
from instrument.tracking.smoothing import Smooth, smooth
from protocols import Floats, Singles

_FEWEST = 64  # frames below which an image is too poor to refine anything
_LEAST_INFORMATION = 1e-3  # of the best frame's: a frame that tells less makes no step of its own
_BLOCKS = (8, 32)  # of a run, to see slow errors in: fewest and most
_BLOCK = 50  # frames in one of them: some pixels of way, longer than dithering keeps its error
_LEAST_VARIANCE = 0.02  # of the mean: dark frames of photon counts are not certain
_TINY = 1e-12
_WORSE = 1.05  # times the misfit of the motion given: a refined one that explains the values worse than that is dropped
_STANDS = 0.2  # of the uncertainty: a change of the motion below that is none


@dataclass(frozen=True, eq=False)
class Refined:
    """Motion and image that explain the values together."""

    trajectory: Trajectory
    """Displacement with its uncertainty, relative to frame 0."""

    image: Reconstruction
    """At frame 0."""

    loops: int
    """Refinements of the motion; 0 where the motion given was kept."""


@one_blas_thread()
def refine(recording: Recording, motion: Trajectory | Floats, *, region: bool = True, loops: int = 8) -> Refined:
    """Refine a trajectory by all that was measured, and reconstruct the image.

    Each loop solves for the image (warm start), predicts all values of every frame with it, the four Fourier values from the
    binary patterns as shown (so that dithering is no error any more) and the Hadamard difference, and makes one Gauss-Newton
    step for the whole path: each frame's displacement that would explain its values best, weighted by its information,
    smoothed as far as the data say. The last image starts anew: what earlier ones invented, with a worse motion, would stay.

    Of each axis's two Fourier values only the direction in which motion turns them counts, not the amplitude: an image too
    smooth or too dark is no motion. Photon counts are weighted by the counts expected: weighting by those that came would
    favour low ones, and with few counts that is a bias of the motion larger than its noise.

    The stated uncertainty is the smoother's, and more where the image leaves slow errors in the Fourier values: seen in their
    amplitude, in which there is no motion, and counted in proportion to what these values tell of the motion. It does not know
    of a bend at the run's ends too weak for the data to show.

    Where the refined motion explains the values worse than the one given, that one is kept: patterns too alike, of a plan that
    shows few of them in an unlucky order, make an image that leads astray.

    Args:
        recording: of the six-pattern scheme.
        motion: where to start, within about a pixel: what ``track`` gave.
        region: as in ``reconstruct``.
        loops: at most so many. It ends earlier where the motion changes by less than a fifth of its uncertainty.

    Raises:
        InputError: as ``reconstruct``.
    """
    measurement = Measurement.of(recording, steady_object=region)
    trajectory = as_trajectory(motion, recording)
    places = places_px(trajectory, recording, measurement)
    size = measurement.size
    area = Region.inside(places.reshape(-1, 2), size) if region else Region.whole(size)
    rows, values = measurement.hadamard(places, area)
    start, started = trajectory, (rows, values)
    misfits: list[float] = []
    state = None
    fixed = FixedPatterns.of(scheme_of(recording.plan), area)
    total: Floats = measurement.values[:, POSITIVE] + measurement.values[:, NEGATIVE]
    if len(total) >= _FEWEST:
        total = smooth(total, np.ones(len(total)), orders=(1,)).values
    done = 0
    while len(measurement.frame) >= _FEWEST and done < loops:
        state = total_variation(rows, values, tolerance=0.03, iterations=40, start=state)
        misfits.append(state.misfit)
        step = _step(measurement, fixed, total, trajectory, places=places, image=state.image)
        before, trajectory = trajectory, step.trajectory(trajectory)
        places = places_px(trajectory, recording, measurement)
        rows, values = measurement.hadamard(places, area)
        done += 1
        change = trajectory.displacement_px - before.displacement_px
        if np.mean(change**2) < _STANDS**2 * np.mean(trajectory.sigma_px**2):
            break
    state = total_variation(rows, values)
    if misfits and state.misfit > _WORSE * misfits[0]:
        trajectory, done = start, 0
        state = total_variation(*started)
    return Refined(trajectory, finished(measurement, area, state.image, "tv", state), done)


@dataclass(frozen=True, eq=False)
class _Step:
    """The smoothed path along each axis, and by how much its variance is to be enlarged."""

    fits: tuple[Smooth, ...]
    excess: tuple[float, ...]

    def trajectory(self, last: Trajectory) -> Trajectory:
        path = np.stack([fit.values for fit in self.fits], axis=1)
        variance = np.stack([fit.variance_to_first for fit in self.fits], axis=1) * np.array(self.excess)
        return Trajectory(path - path[0], np.sqrt(variance), last.frame_time_s, "joint", last.valid)


def _step(
    measurement: Measurement,
    fixed: FixedPatterns,
    total: Floats,
    trajectory: Trajectory,
    *,
    places: Floats,
    image: Singles,
) -> _Step:
    """One Gauss-Newton step for x, then for y, each smoothed over the whole run."""
    views = _against(measurement, fixed, total, places, image)
    path = trajectory.displacement_px
    fits: list[Smooth] = []
    excess: list[float] = []
    moved = np.zeros((len(measurement.frame), 2))
    for axis in range(2):
        information = np.zeros(len(path))
        pull = np.zeros(len(path))
        for residual, slope in views.rows:
            left = residual - np.vecdot(slope, moved)
            information[measurement.frame] += slope[:, axis] ** 2
            pull[measurement.frame] += slope[:, axis] * left
        wanted = path[:, axis] + pull / np.maximum(information, _LEAST_INFORMATION * information.max())
        fit = smooth(wanted, information, known=True)
        moved[:, axis] = (fit.values - path[:, axis])[measurement.frame]
        fits.append(fit)
        share = float(np.sum(views.rows[axis][1][:, axis] ** 2) / information.sum())
        excess.append(1 + share * (_slowness(views.amplitude[axis]) - 1))
    return _Step(tuple(fits), tuple(excess))


def _slowness(amplitude: Floats) -> float:
    """Power of slow errors in an amplitude, over that of white noise of variance 1; at least 1."""
    block = max(2, len(amplitude) // min(max(len(amplitude) // _BLOCK, _BLOCKS[0]), _BLOCKS[1]))
    means = amplitude[: len(amplitude) // block * block].reshape(-1, block).mean(axis=1)
    return max(1.0, float(means.var(ddof=1)) * block)


@dataclass(frozen=True, eq=False)
class _Views:
    """What each frame says of its place, over the noise."""

    rows: tuple[tuple[Floats, Floats], ...]
    """Of the Fourier pair along x, that along y, and the Hadamard difference: residuals ``(rows,)``, and their derivatives by
    x and y, ``(rows, 2)``."""

    amplitude: tuple[Floats, ...]
    """``(rows,)`` for each Fourier pair: what is left of it at right angles to motion."""


def _against(measurement: Measurement, fixed: FixedPatterns, total: Floats, places: Floats, image: Singles) -> _Views:
    """Compare the values with those of an image.

    Of Fourier values and their predictions, half of the total light is taken off, measured and predicted: an image a little too
    dark is no motion, nor is haze in the image that leaves the field before the object does.
    """
    fourier, slope = fixed.values(fixed.maps(image), places[:, :POSITIVE])
    field = FixedPatterns(np.ones_like(fixed.patterns[:1]), fixed.region, fixed.width)
    lit, _ = field.values(field.maps(image), places[:, :POSITIVE].mean(axis=1, keepdims=True))
    expected = fourier + (total[:, None] - lit) / 2
    residual = measurement.values[:, :POSITIVE] - expected
    variance = _expected_variance(measurement, expected)
    rows: list[tuple[Floats, Floats]] = []
    amplitude: list[Floats] = []
    for axis in range(2):
        pair = slice(2 * axis, 2 * axis + 2)
        own = slope[:, pair, axis]
        turn: Floats = own / (np.linalg.norm(own, axis=1)[:, None] + _TINY)
        across: Floats = turn[:, ::-1] * [-1.0, 1.0]
        sigma: Floats = np.sqrt(np.sum(turn**2 * variance[:, pair], axis=1))
        turned: Floats = np.sum(turn * residual[:, pair], axis=1) / sigma
        rows.append((turned, np.einsum("rp,rpa->ra", turn, slope[:, pair]) / sigma[:, None]))
        aside: Floats = np.sqrt(np.sum(across**2 * variance[:, pair], axis=1))
        amplitude.append(np.sum(across * residual[:, pair], axis=1) / aside)
    rows.append(_hadamard(measurement, places, image, fixed.region))
    return _Views(tuple(rows), tuple(amplitude))


def _expected_variance(measurement: Measurement, expected: Floats) -> Floats:
    """Variance of the Fourier values if they were as expected, from how those that came go with their variances."""
    values, variance = measurement.values[:, :POSITIVE], measurement.variance[:, :POSITIVE]
    if not measurement.photon_counts:
        return variance
    spread: Floats = values - float(values.mean())
    slope = float(np.vdot(spread, variance) / (np.vdot(spread, spread) + _TINY))
    least = float(variance.mean()) * _LEAST_VARIANCE
    line: Floats = float(variance.mean()) + slope * (expected - float(values.mean()))
    return np.maximum(line, least)


def _hadamard(measurement: Measurement, places: Floats, image: Singles, region: Region) -> tuple[Floats, Floats]:
    """Residuals of the Hadamard differences, and their derivatives by x and y, over the noise."""
    size, (x_px, y_px) = measurement.size, places[:, POSITIVE:].mean(axis=1).T
    down, steep_down = (
        walsh_rows(size, measurement.pairs[:, 0], y_px, region.top, region.height, slope=slope)
        for slope in (False, True)
    )
    across, steep_across = (
        walsh_rows(size, measurement.pairs[:, 1], x_px, region.left, region.width, slope=slope)
        for slope in (False, True)
    )
    columns = down @ image
    sigma = measurement.difference_sigma
    by_x: Floats = np.vecdot(columns, steep_across)
    by_y: Floats = np.vecdot(steep_down @ image, across)
    slope: Floats = np.stack([by_x, by_y], axis=-1)
    return (measurement.difference - np.vecdot(columns, across)) / sigma, slope / sigma[:, None]
