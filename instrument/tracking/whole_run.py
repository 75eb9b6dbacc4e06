"""The default tracker: a smooth path through all positions, with a smoothness that the data decide, and its uncertainty."""

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from instrument.measurement import Measurement
from instrument.numerics import Smooth, smooth
from instrument.schemes import Observation
from instrument.tracking.covariance import PathCovariance
from instrument.tracking.trajectory import Trajectory
from instrument.tracking.unwrapping import unwrapped_px
from protocols import Floats, Mask

_Fits: TypeAlias = tuple[Smooth, Smooth]
_FEWEST_FRAMES = 8  # below which nothing is smoothed
_BLOCKS = (
    32  # blocks of a run in which slow errors are seen, each a few times longer than an error of the dithering lasts
)
_DITHER_LENGTH_PX = 1.0  # correlation length of the error of the dithered patterns


def track_smooth(measurement: Measurement, reference_frame: int = 0) -> Trajectory:
    """Fit a smoothing spline of data-driven order and strength to the positions, each value at its own time.

    The first path predicts the positions at the times of the patterns. The measured positions are corrected by that prediction
    to the middle of their frame, and the path is fitted again. The variance is the sum of the spline's posterior variance and of
    the error of the dithered patterns that passes the smoothing. That error is seen in the signal's amplitude, which has the same
    noise and does not change with motion.

    Args:
        measurement: what was measured.
        reference_frame: frame that displacements and their uncertainty are relative to.

    Raises:
        InputError: no frame is usable, or the scheme has no position.
    """
    found = measurement.observe(steady=True)
    place_px = unwrapped_px(found)
    if np.count_nonzero(found.valid) < _FEWEST_FRAMES:
        variance = found.variance_px2(place_px)
        variance += variance[reference_frame]
        variance[reference_frame] = 0.0
        return _trajectory(measurement, place_px, variance, found.valid, reference_frame)

    path_px = _path_px(_fitted(found, place_px, place_px))
    fits = _fitted(found, found.in_mid_frame_px(path_px), path_px)
    path_px = _path_px(fits)

    variance = np.stack([fit.variance_to(reference_frame) for fit in fits], axis=1)
    amplitude_px = found.amplitude_px(path_px)
    if amplitude_px is not None:
        distance_px: Floats = np.hypot(*(path_px - path_px[reference_frame]).T)
        changed = 1 - np.exp(-((distance_px / _DITHER_LENGTH_PX) ** 2))
        for axis, fit in enumerate(fits):
            error = _dither_error(amplitude_px[:, axis], found.valid, fit.noise_variance)
            variance[:, axis] += np.minimum(error.slow_ratio * variance[:, axis], 2 * error.variance * changed)
    path = _trajectory(measurement, path_px, variance, found.valid, reference_frame)
    return replace(path, covariance=PathCovariance.of(fits, path.sigma_px, reference_frame))


def _fitted(found: Observation, place_px: Floats, near_px: Floats) -> _Fits:
    """Smooth both axes, each frame weighted by the inverse of its variance at the position ``near_px``.

    Both arrays are ``(frames, 2)``.
    """
    variance = found.variance_px2(near_px)
    known = np.isfinite(variance) & (variance > 0)
    weights = np.zeros_like(variance)
    weights[known] = 1 / variance[known]
    if not known.any():
        weights[found.valid] = 1.0
    x, y = (smooth(place_px[:, axis], weights[:, axis], absolute_weights=bool(known.any())) for axis in range(2))
    return x, y


def _path_px(fits: _Fits) -> Floats:
    return np.stack([fit.values for fit in fits], axis=1)


def _trajectory(
    measurement: Measurement, place_px: Floats, variance_px2: Floats, valid: Mask, reference_frame: int
) -> Trajectory:
    displacement_px = place_px - place_px[reference_frame]
    sigma_px = np.sqrt(variance_px2) * measurement.student_ratio
    time_s = measurement.frame_time_s
    return Trajectory(displacement_px, sigma_px, time_s, "smooth", valid, reference_frame=reference_frame)


@dataclass(frozen=True)
class _DitherError:
    """Error that the dithered patterns add to the noise of a signal."""

    slow_ratio: float
    """Variance of errors slower than a block, over that of the noise."""

    variance: float
    """Variance of the error itself, in the unit of the noise variance."""


def _dither_error(amplitude: Floats, valid: Mask, noise_variance: float) -> _DitherError:
    """Estimate the error of the dithered patterns from the signal's amplitude, ``(frames,)``.

    Dithering gives each position of the object an error of its own, which therefore changes with the distance moved: more slowly
    than noise. Its variance is the mean covariance of frames that are 1 to 4 frames apart.
    """
    deviation = np.where(valid, amplitude - amplitude[valid].mean(), 0.0)
    block = max(2, len(deviation) // _BLOCKS)
    means = deviation[: len(deviation) // block * block].reshape(-1, block).mean(axis=1)
    slow_ratio = max(0.0, float(means.var()) * block / noise_variance - 1) if noise_variance > 0 else 0.0
    covariance = np.mean([np.mean(deviation[lag:] * deviation[:-lag]) for lag in (1, 2, 3, 4)])
    return _DitherError(slow_ratio, max(0.0, float(covariance)))
