"""The default tracker: one smooth path through all positions, as smooth as the data say, with its uncertainty."""

from typing import TypeAlias

import numpy as np

from instrument.measurement import Measurement
from instrument.numerics import Smooth, smooth
from instrument.schemes import Observation
from instrument.tracking.trajectory import Trajectory
from instrument.tracking.unwrapping import followed_px
from protocols import Floats, Mask

_Fits: TypeAlias = tuple[Smooth, Smooth]
_FEWEST = 8
_BLOCKS = 32  # of a run, to see slow errors in: each a few times longer than dithering keeps its error
_DITHER_REACH_PX = 1.0  # distance after which the error of the dithered patterns has become another one


def track_smooth(measurement: Measurement) -> Trajectory:
    """Fit a smoothing spline of data-driven order and strength to the positions, each value at its own time.

    The positions are compared with those that the path itself predicts for the times of the patterns, and the path is fitted
    again. The uncertainty adds the spline's posterior variance and the error of the dithered patterns that passes the smoothing,
    as the signal's amplitude shows it, which has the same noise and no motion in it.

    Raises:
        InputError: no usable frame, or a scheme without position.
    """
    found = measurement.observe(steady=True)
    place_px = followed_px(found)
    if np.count_nonzero(found.valid) < _FEWEST:
        variance = found.variance_px2(place_px)
        variance[1:] += variance[0]
        variance[0] = 0.0
        return _trajectory(measurement, place_px, variance, found.valid)

    path_px = _path_px(_fitted(found, place_px, place_px))
    fits = _fitted(found, found.in_mid_frame_px(path_px), path_px)
    path_px = _path_px(fits)

    variance = np.stack([fit.variance_to_first for fit in fits], axis=1)
    amplitude_px = found.amplitude_px(path_px)
    if amplitude_px is not None:
        distance_px: Floats = np.hypot(*(path_px - path_px[0]).T)
        changed = 1 - np.exp(-((distance_px / _DITHER_REACH_PX) ** 2))
        for axis, fit in enumerate(fits):
            slow, whole = _dither(amplitude_px[:, axis], found.valid, fit.noise_variance)
            variance[:, axis] += np.minimum(slow * variance[:, axis], 2 * whole * changed)
    return _trajectory(measurement, path_px, variance, found.valid)


def _fitted(found: Observation, place_px: Floats, near_px: Floats) -> _Fits:
    """Smooth both axes, each frame weighted by the variance that it has if its position is about ``near_px``."""
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


def _trajectory(measurement: Measurement, place_px: Floats, variance_px2: Floats, valid: Mask) -> Trajectory:
    displacement_px = place_px - place_px[0]
    return Trajectory(displacement_px, np.sqrt(variance_px2), measurement.frame_time_s, "smooth", valid)


def _dither(amplitude: Floats, valid: Mask, white: float) -> tuple[float, float]:
    """Find what the dithered patterns do to the signal beside noise, seen in its amplitude.

    Dithering is a fixed error for each place of the object: it comes and goes with the distance, more slowly than noise.

    Returns:
        The variance of slow errors over that of the noise, and the variance of the dithering itself, in the unit of ``white``.
    """
    rest = np.where(valid, amplitude - amplitude[valid].mean(), 0.0)
    block = max(2, len(rest) // _BLOCKS)
    means = rest[: len(rest) // block * block].reshape(-1, block).mean(axis=1)
    slow = max(0.0, float(means.var()) * block / white - 1) if white > 0 else 0.0
    neighbours = np.mean([np.mean(rest[lag:] * rest[:-lag]) for lag in (1, 2, 3, 4)])
    return slow, max(0.0, float(neighbours))
