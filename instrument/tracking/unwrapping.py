"""Positions unwrapped from frame to frame, each of which is known only within a period."""

import numpy as np

from instrument.schemes import Observation, Signals
from protocols import Floats, Mask

_CLEAR = 7.0  # amplitude over noise from which on no frame of a run is unwrapped to a wrong period
_WINDOWS = (1, 3, 5, 9, 15, 25)  # frames that are averaged


def unwrapped_px(observation: Observation) -> Floats:
    """Unwrap the position of every frame.

    Where a single frame is too noisy, the path is first unwrapped on signals averaged over as many frames as make their phase
    clear, up to 25. Each frame's own position is then the one nearest to that path. A position without a period is not unwrapped.

    Returns:
        ``(frames, 2)`` position in px, x and y, interpolated linearly over frames that are not valid.
    """
    reading, valid = observation.reading, observation.valid
    index = np.arange(len(valid))
    place_px = np.empty((len(valid), 2))
    for axis in range(2):
        signal = observation.signal[:, axis]
        if observation.period_px is None:
            place_px[:, axis] = np.interp(index, index[valid], signal.real[valid])
            continue
        _, deviation = observation.amplitude()
        mean = _clear_mean(signal, valid, float(deviation[axis]))
        whole = np.unwrap(reading.displacement_px(mean[valid], reading.origin), period=observation.period_px)
        path = np.interp(index, index[valid], whole)
        expected = np.exp(-2j * np.pi / observation.period_px * path)
        place_px[:, axis] = path + np.where(valid, reading.displacement_px(signal, expected), 0.0)
    return place_px


def _clear_mean(signal: Signals, valid: Mask, deviation: float) -> Signals:
    """Average over the fewest frames that make the phase clear; or, where fast motion lets none do so, over the best number."""
    best, clearest = signal, 0.0
    for window in _WINDOWS:
        if window > len(signal) or not np.isfinite(deviation):
            break
        mean = np.convolve(signal, np.ones(window), "same")
        clear = float(np.median(np.abs(mean[valid]))) / (deviation * np.sqrt(window) + 1e-300)
        if clear > clearest:
            best, clearest = mean, clear
        if clear >= _CLEAR:
            break
    return best
