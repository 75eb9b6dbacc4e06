"""Joint refinement: motion from all values against the current image, the image again with that motion, until both stand."""

from dataclasses import dataclass

import numpy as np

from instrument.reconstruction.correlation import FixedPatterns
from instrument.reconstruction.operator import Singles, walsh_factors
from instrument.reconstruction.reconstruct import Reconstruction, finished
from instrument.reconstruction.region import Region
from instrument.reconstruction.rows import NEGATIVE, POSITIVE, Measurement, as_trajectory, places_px
from instrument.reconstruction.tv import total_variation
from instrument.recording import Recording
from instrument.schemes import scheme_of
from instrument.tracking import Trajectory
from instrument.tracking.smoothing import Smooth, smooth
from protocols import Floats

_FEWEST = 64  # frames below which an image is too poor to refine anything
_ORDERS = (3, 2, 1)  # of the smoother: the smoothest first, as its ends follow a bent way best
_LEAST_INFORMATION = 1e-3  # of the best frame's: a frame that tells less makes no step of its own
_BLOCKS = 32  # of a run, to see slow errors in
_CLEAR = 17.0  # light of a half-lit pattern over its noise, below which the image is too poor to improve on the tracker
_STANDS = 0.2  # of the uncertainty: a change of the motion below that is none


@dataclass(frozen=True, eq=False)
class Refined:
    """Motion and image that explain the values together."""

    trajectory: Trajectory
    """Displacement with its uncertainty, relative to frame 0."""

    image: Reconstruction
    """At frame 0."""

    loops: int
    """Refinements of the motion."""


def refine(recording: Recording, motion: Trajectory | Floats, *, region: bool = True, loops: int = 4) -> Refined:
    """Refine a trajectory by all that was measured, and reconstruct the image.

    Each loop solves for the image (warm start), predicts all values of every frame with it, the four Fourier values from the
    binary patterns as shown (so that dithering is no error any more) and the Hadamard difference, and makes one Gauss-Newton
    step for the whole path: each frame's displacement that would explain its values best, weighted by its information,
    smoothed as far as the data say.

    The stated uncertainty is the smoother's, and more where the image leaves slow errors in the Fourier values: seen in their
    amplitude, in which there is no motion. It does not know of a bend at the run's ends too weak for the data to show.

    Where there is little light (half-lit patterns below 17 times their noise, some 290 counts) the motion stays as it was given:
    the image is then too poor, and refinement was seen to make motion worse.

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
    state = None
    step: _Step | None = None
    fixed = FixedPatterns.of(scheme_of(recording.plan), area)
    light: Floats = measurement.values[:, POSITIVE:] / np.sqrt(measurement.variance[:, POSITIVE:])
    worth = len(measurement.frame) >= _FEWEST and float(np.median(light)) >= _CLEAR
    done = 0
    while worth and done < loops:
        state = total_variation(rows, values, tolerance=0.03, iterations=60, start=state)
        step = _step(measurement, fixed, trajectory, places=places, image=state.image, last=step)
        before, trajectory = trajectory, step.trajectory(trajectory)
        places = places_px(trajectory, recording, measurement)
        rows, values = measurement.hadamard(places, area)
        done += 1
        change = trajectory.displacement_px - before.displacement_px
        if np.mean(change**2) < _STANDS**2 * np.mean(trajectory.sigma_px**2):
            break
    state = total_variation(rows, values, start=state)
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
    trajectory: Trajectory,
    *,
    places: Floats,
    image: Singles,
    last: _Step | None,
) -> _Step:
    """One Gauss-Newton step for x, then for y, each smoothed over the whole run."""
    residual, slope = _against(measurement, fixed, places, image)
    path = trajectory.displacement_px
    fits: list[Smooth] = []
    excess: list[float] = []
    for axis in range(2):
        information = np.zeros(len(path))
        pull = np.zeros(len(path))
        information[measurement.frame] = np.sum(slope[..., axis] ** 2, axis=1)
        pull[measurement.frame] = np.sum(slope[..., axis] * residual, axis=1)
        wanted = path[:, axis] + pull / np.maximum(information, _LEAST_INFORMATION * information.max())
        fit = smooth(wanted, information, orders=_ORDERS, known=True, near=None if last is None else last.fits[axis])
        moved = (fit.values - path[:, axis])[measurement.frame]
        residual = residual - slope[..., axis] * moved[:, None]
        fits.append(fit)
        pair = slice(2 * axis, 2 * axis + 2)
        excess.append(_slowness(residual[:, pair], slope[:, pair, axis]))
    return _Step(tuple(fits), tuple(excess))


def _slowness(residual: Floats, slope: Floats) -> float:
    """Power of slow errors in the amplitude of a pair of Fourier values, over that of white noise; at least 1.

    Args:
        residual: ``(rows, 2)`` over the noise.
        slope: ``(rows, 2)``: the direction of motion, at right angles to that of amplitude.
    """
    length = np.hypot(slope[:, 0], slope[:, 1]) + 1e-12
    amplitude = (slope[:, 0] * residual[:, 1] - slope[:, 1] * residual[:, 0]) / length
    block = max(2, len(amplitude) // _BLOCKS)
    means = amplitude[: len(amplitude) // block * block].reshape(-1, block).mean(axis=1)
    return max(1.0, float(means.var()) * block)


def _against(measurement: Measurement, fixed: FixedPatterns, places: Floats, image: Singles) -> tuple[Floats, Floats]:
    """Residuals of the four Fourier values and the Hadamard difference, and their derivatives by x and y, over the noise.

    Of Fourier values and their predictions, half of the total light is taken off: an image a little too dark is no motion.

    Returns:
        ``(rows, 5)`` and ``(rows, 5, 2)``.
    """
    fourier, fourier_slope = fixed.values(fixed.maps(image), places[:, :POSITIVE])
    total = np.mean(measurement.values[:, POSITIVE] + measurement.values[:, NEGATIVE])
    seen = measurement.values[:, :POSITIVE] - (total - image.sum()) / 2
    middle = places[:, POSITIVE:].mean(axis=1)
    down, across = walsh_factors(measurement.pairs, middle, measurement.size, fixed.region)
    steep = walsh_factors(measurement.pairs, middle, measurement.size, fixed.region, slope=True)
    columns = down @ image
    hadamard = np.vecdot(columns, across)
    hadamard_slope = np.stack([np.vecdot(columns, steep[1]), np.vecdot(steep[0] @ image, across)], axis=-1)
    sigma = np.concatenate([np.sqrt(measurement.variance[:, :POSITIVE]), measurement.difference_sigma[:, None]], axis=1)
    residual = np.concatenate([seen - fourier, (measurement.difference - hadamard)[:, None]], axis=1) / sigma
    slope = np.concatenate([fourier_slope, hadamard_slope[:, None]], axis=1) / sigma[..., None]
    return residual, slope
