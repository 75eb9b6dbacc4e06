"""The default tracker: one smooth path through all phases, as smooth as the data say, with its uncertainty."""

from typing import TypeAlias

import numpy as np

from instrument.recording import Recording
from instrument.tracking.coefficients import Coefficients, Measured, measured, unwrapped
from instrument.tracking.smoothing import Smooth, smooth
from instrument.tracking.trajectory import Trajectory
from protocols import Floats, Mask

_Fits: TypeAlias = tuple[Smooth, Smooth]
_FEWEST = 8
# Middle of patterns 1 to 4 against the middle of their frame, in frames: (axis, pattern of the pair).
_OFFSET = (np.array([[0.5, 1.5], [2.5, 3.5]]) - 3.0) / 6
_BLOCKS = 32  # of a run, to see slow errors in: each a few times longer than dithering keeps its error
_DITHER_REACH_PX = 1.0  # way after which the error of the dithered patterns has become another one


def track_smooth(recording: Recording) -> Trajectory:
    """Fit a smoothing spline of data-driven order and strength to the phases, each value at its own time.

    The phases are compared with those that the path itself predicts for the times of the six patterns, and the path is fitted
    again. The uncertainty adds the spline's posterior variance and the error of the dithered patterns that passes the smoothing,
    as the coefficients' amplitude shows it, which has the same noise and no motion in it.

    Raises:
        InputError: no usable frame.
    """
    found = measured(recording, smooth_total=True)
    radians = 2 * np.pi * recording.plan.frequency_per_px
    phase = unwrapped(found)
    if np.count_nonzero(found.valid) < _FEWEST:
        variance = found.phase_variance(phase)
        variance[1:] += variance[0]
        variance[0] = 0.0
        return _trajectory(recording, phase, variance, found.valid, radians)

    first = _fitted(found, phase, phase)
    path = _path(first)
    fits = _fitted(found, _against(found, path), path)
    path = _path(fits)

    way_px: Floats = np.hypot(path[:, 0] - path[0, 0], path[:, 1] - path[0, 1]) / radians
    changed = 1 - np.exp(-((way_px / _DITHER_REACH_PX) ** 2))
    amplitude, _ = found.clarity()
    seen: Floats = (found.coefficient * np.conj(_direction(path))).real / amplitude
    variance = np.empty_like(path)
    for axis, fit in enumerate(fits):
        own = fit.variance_to_first
        slow, whole = _dither(seen[:, axis], found.valid, fit.noise_variance)
        variance[:, axis] = own + np.minimum(slow * own, 2 * whole * changed)
    return _trajectory(recording, path, variance, found.valid, radians)


def _fitted(found: Measured, phase: Floats, near_phase: Floats) -> _Fits:
    """Smooth both axes, each frame weighted by the variance that it has if its phase is about ``near_phase``."""
    variance = found.phase_variance(near_phase)
    known = np.isfinite(variance) & (variance > 0)
    weights = np.zeros_like(variance)
    weights[known] = 1 / variance[known]
    if not known.any():
        weights[found.valid] = 1.0
    x, y = (smooth(phase[:, axis], weights[:, axis], known=bool(known.any())) for axis in range(2))
    return x, y


def _path(fits: _Fits) -> Floats:
    return np.stack([fit.values for fit in fits], axis=1)


def _against(found: Measured, path: Floats) -> Floats:
    """Each frame's phase in its middle: that of the path, and by how much the frame's coefficient is turned against it."""
    aside = np.angle(found.coefficient * np.conj(_direction(path)))
    return path + np.where(found.valid[:, None], aside, 0.0)


def _trajectory(recording: Recording, phase: Floats, variance: Floats, valid: Mask, radians: float) -> Trajectory:
    return Trajectory(
        (phase - phase[0]) / -radians, np.sqrt(variance) / radians, recording.frame_time_s, "smooth", valid
    )


def _direction(path: Floats) -> Coefficients:
    """Coefficients of amplitude 1 that would be measured on this path: real and imaginary part at their patterns' times."""
    velocity = np.gradient(path, axis=0)
    acceleration = np.gradient(velocity, axis=0)
    at_0, at_90 = (path + velocity * offset + acceleration * (offset**2 / 2) for offset in _OFFSET.T)
    turned: Coefficients = np.cos(at_0) + 1j * np.sin(at_90)
    return turned


def _dither(amplitude: Floats, valid: Mask, white: float) -> tuple[float, float]:
    """What the dithered patterns do to the coefficients beside noise, seen in their relative amplitude.

    Dithering is a fixed error for each place of the object: it comes and goes with the way, more slowly than noise.

    Returns:
        Its share of slow errors, over the noise's, and its variance in rad^2.
    """
    rest = np.where(valid, amplitude - amplitude[valid].mean(), 0.0)
    block = max(2, len(rest) // _BLOCKS)
    means = rest[: len(rest) // block * block].reshape(-1, block).mean(axis=1)
    slow = max(0.0, float(means.var()) * block / white - 1) if white > 0 else 0.0
    neighbours = np.mean([np.mean(rest[lag:] * rest[:-lag]) for lag in (1, 2, 3, 4)])
    return slow, max(0.0, float(neighbours))
