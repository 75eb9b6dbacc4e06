"""The angle of an object that turns, from the moments of second order, smoothed over the whole run.

A frame's elongation z = A exp(2 j angle) is noisy: its noise is often larger than A. The rate of turning is found first, as the
one at which the sum of z exp(-2 j rate t) over the run is largest (the peak of a periodogram). Against that steady turn the rest
is slow, and is smoothed as far as the values ask for it, again and again, until it changes by less than its uncertainty.
"""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from instrument.measurement import Measurement
from instrument.numerics import smooth
from instrument.schemes import TurnReading
from instrument.tracking.trajectory import Trajectory
from protocols import Floats

_MOST_TURNS: Final = 4.0
"""Turns of a run, to either side, among which the rate is looked for."""

_PARTS: Final = 8
"""Rates that are tried for each half turn of a run: a peak is two wide."""

_PASSES: Final = 6

_FEWEST_FRAMES: Final = 16


def with_angle(measurement: Measurement, trajectory: Trajectory, turn: TurnReading) -> Trajectory:
    """Give a trajectory with the angle by which the object has turned since frame 0.

    Args:
        measurement: what was measured.
        trajectory: path of the centroid, with its position at frame 0.
        turn: how values become an angle.
    """
    if trajectory.start_px is None:
        return trajectory
    total = measurement.steady_total
    valid = measurement.valid & (total > 0)
    time_s = measurement.pattern_time_s[:, turn.columns]
    place_px = trajectory.start_px + trajectory.at(time_s)
    light = np.where(valid, total, 1.0)[:, None]
    shares = np.where(valid[:, None], measurement.values[:, turn.columns], 0.0) / light
    real, imaginary = turn.elongation_px2(shares, place_px[:, 0], place_px[:, 1])
    variance = turn.part_variance_px4(measurement.variance[:, turn.columns] / light**2)
    elongation = np.where(valid, real + 1j * imaginary, 0.0)
    if np.count_nonzero(valid) < _FEWEST_FRAMES or not np.isfinite(variance[valid]).all():
        nothing = np.full(len(valid), np.inf)
        return replace(trajectory, angle_deg=np.zeros(len(valid)), angle_sigma_deg=nothing)
    phase, variance_rad2 = _phase(elongation, np.where(valid, variance.mean(axis=1), np.inf))
    return replace(
        trajectory,
        angle_deg=np.rad2deg((phase - phase[0]) / 2),
        angle_sigma_deg=np.rad2deg(np.sqrt(variance_rad2) / 2),
    )


def _phase(elongation: NDArray[np.complex128], variance: Floats) -> tuple[Floats, Floats]:
    """Give the phase of a noisy signal over the run, and the variance of its change since frame 0, both ``(frames,)``.

    Args:
        elongation: ``(frames,)``; 0 where nothing is known.
        variance: ``(frames,)`` of each of its parts; infinite where nothing is known.
    """
    frames = len(elongation)
    step = np.pi / _PARTS / frames * 2
    rates = np.arange(-_MOST_TURNS * 4 * np.pi / frames, _MOST_TURNS * 4 * np.pi / frames + step / 2, step)
    frame = np.arange(frames)
    power = np.abs(np.exp(-1j * np.outer(rates, frame)) @ elongation)
    rate = float(rates[int(power.argmax())])
    known = np.isfinite(variance)
    phase = rate * frame
    phase += float(np.angle(np.sum(elongation * np.exp(-1j * phase))))
    phase_variance = np.full(frames, np.inf)
    for _ in range(_PASSES):
        turned = elongation * np.exp(-1j * phase)
        amplitude = max(float(turned.real[known].mean()), 1e-12)
        weights = np.where(known, amplitude**2 / np.where(known, np.maximum(variance, 1e-30), 1.0), 0.0)
        fit = smooth(phase + turned.imag / amplitude, weights, absolute_weights=True)
        change, phase = fit.values - phase, fit.values
        phase_variance = fit.variance_to_first
        if np.mean(change**2) < 0.01 * float(phase_variance.mean()):
            break
    return np.asarray(phase, np.float64), np.asarray(phase_variance, np.float64)
