"""The motions on which trackers are judged, and the object that moves: half a second, 1,666 frames, 128 x 128 pixels."""

import numpy as np

from protocols import Floats
from sim_backends.bench.objects import BUILT_INS
from tests.support.simulation import Path2D

FRAMES = 1666
RUN_S = FRAMES * 6 * 50e-6


def letter_b(top: int = 6, left: int = 10, size: int = 128) -> Floats:
    """The "B", 36 px high, about 5 % of the field."""
    cells = BUILT_INS["letter-B"](36).cells
    image = np.zeros((size, size))
    image[top : top + cells.shape[0], left : left + cells.shape[1]] = cells
    return image


def _curve(time_s: Floats) -> Floats:
    """I: a gentle S, 66 px across and 64 px down."""
    u = time_s / RUN_S
    return np.stack([66 * u + 4 * np.sin(2 * np.pi * u), 6.4 * u + 57.6 * (3 * u**2 - 2 * u**3)], axis=1)


def _accelerated(time_s: Floats) -> Floats:
    """II: along the diagonal by v0 t + a t^2 / 2 in the ratio of 25 mm/s and 50 mm/s^2, 66 px each way."""
    u = time_s / RUN_S
    distance_px = 66 * (2 * u / 3 + u**2 / 3)
    return np.stack([distance_px, distance_px], axis=1)


def _vibration(periods: int) -> Path2D:
    def path(time_s: Floats) -> Floats:
        angle = 2 * np.pi * periods * time_s / RUN_S
        shaken: Floats = _curve(time_s) + np.stack([np.sin(angle), np.cos(angle) - 1], axis=1)
        return shaken

    return path


def _circle(time_s: Floats) -> Floats:
    """40 turns, 3 px a frame."""
    angle = 2 * np.pi * 40 * time_s / RUN_S
    radius = 3 * FRAMES / 40 / (2 * np.pi)
    return 24 + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _random_walk(time_s: Floats) -> Floats:
    """Steps of 0.5 px rms a frame and axis, thrown back at the edges."""
    steps = np.random.default_rng(5).normal(size=(FRAMES + 2, 2)) * 0.5
    places = np.abs((np.cumsum(steps, axis=0) + 20) % 128 - 64)
    frame = np.arange(FRAMES + 2) * RUN_S / FRAMES
    return np.stack([np.interp(time_s, frame, places[:, axis]) for axis in range(2)], axis=1)


def _stop_and_go(time_s: Floats) -> Floats:
    """Eight times: 8 px at constant speed, then as long a rest."""
    turn = np.floor(time_s / RUN_S * 8)
    distance_px = 8 * (turn + np.minimum(2 * (time_s / RUN_S * 8 - turn), 1))
    return np.stack([distance_px, 0.9 * distance_px], axis=1)


MOTIONS: dict[str, Path2D] = {
    "I": _curve,
    "II": _accelerated,
    "vibration-50": _vibration(50),
    "vibration-200": _vibration(200),
    "circle": _circle,
    "random-walk": _random_walk,
    "stop-and-go": _stop_and_go,
}
"""Name to path; the first two are smooth."""
