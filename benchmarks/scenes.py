"""What the benchmarks look at, how it moves, and how it is recorded: 128 x 128 pixels, 1,666 frames, half a second."""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from instrument import Plan, Recording, simulate
from instrument.studies import accelerated, curve
from protocols import Floats
from sim_backends.bench.objects import BUILT_INS

Path2D: TypeAlias = Callable[[Floats], Floats]
"""Seconds ``(n,)`` to displacement ``(n, 2)`` in x, y pixels."""

FRAMES, SIZE = 1666, 128
RUN_S = FRAMES * 6 * 50e-6


def recorded(
    plan: Plan, image: Floats, path: Path2D, *, sigma: float = 0.0, peak_counts: float | None = None, seed: int = 0
) -> Recording:
    """Record an image that moves along a path, by the public ``simulate``.

    Args:
        plan: what is shown.
        image: ``(m, m)`` transmission at displacement 0.
        path: displacement over time.
        sigma: noise of every lit pixel; 0 for none.
        peak_counts: photon counting instead: counts of an all-on pattern.
        seed: of the noise.
    """
    noise: dict[str, Any] = {"kind": "none"}
    if peak_counts is not None:
        noise = {"kind": "poisson", "peak_counts": peak_counts, "seed": seed}
    elif sigma:
        noise = {"kind": "pixel", "sigma": sigma, "seed": seed}
    return simulate(plan, {"noise": noise}, image=image, path=path)


def placed(name: str, top_px: int, left_px: int, *, height_px: float = 36.0, size: int = SIZE) -> Floats:
    """Draw a built-in object with its upper left corner at a row and column, ``(size, size)``."""
    drawing = BUILT_INS[name](height_px)
    finer = round(1 / drawing.cell_px)
    rows, columns = drawing.cells.shape
    field = np.zeros((size * finer, size * finer))
    field[top_px * finer : top_px * finer + rows, left_px * finer : left_px * finer + columns] = drawing.cells
    image: Floats = field.reshape(size, finer, size, finer).mean(axis=(1, 3))
    return image


def scene(name: str) -> Floats:
    """Draw a built-in object 36 px high, near the upper left corner."""
    return placed(name, 22, 22)


def letter_b(top_px: int = 6, left_px: int = 10) -> Floats:
    """Draw the "B", 36 px high, about 5 % of the field."""
    return placed("letter-B", top_px, left_px)


def arc(time_s: Floats) -> Floats:
    """Go along a quarter of a circle of 45 px, 70.7 px of travel."""
    angle = np.pi / 2 * time_s / RUN_S
    way: Floats = 45 * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=1)
    return way


def diagonal(time_s: Floats) -> Floats:
    """Go 66 px along the diagonal, v0 t + a t^2 / 2 at the experiment's ratio."""
    part = time_s / RUN_S
    way: Floats = (66 / np.sqrt(2) * (0.77 * part + 0.23 * part**2))[:, None] * np.ones(2)
    return way


def wavy(time_s: Floats) -> Floats:
    """Go 60 px across and 30 px down, with two waves of 6 px."""
    part = time_s / RUN_S
    way: Floats = np.stack([60 * part, 30 * part + 6 * np.sin(4 * np.pi * part)], axis=1)
    return way


def _vibration(periods: int) -> Path2D:
    def path(time_s: Floats) -> Floats:
        angle = 2 * np.pi * periods * time_s / RUN_S
        shaken: Floats = MOTIONS["I"](time_s) + np.stack([np.sin(angle), np.cos(angle) - 1], axis=1)
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
    way = 8 * (turn + np.minimum(2 * (time_s / RUN_S * 8 - turn), 1))
    return np.stack([way, 0.9 * way], axis=1)


MOTIONS: dict[str, Path2D] = {
    "I": curve(RUN_S),
    "II": accelerated(RUN_S),
    "vibration-50": _vibration(50),
    "vibration-200": _vibration(200),
    "circle": _circle,
    "random-walk": _random_walk,
    "stop-and-go": _stop_and_go,
}
"""Name to path; the first two are smooth, and those of the studies."""
