"""Random objects and random smooth motions that keep them inside the field, for property tests."""

from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st

from protocols import Floats
from sim_backends.bench.objects import BUILT_INS
from tests.support.simulation import Path2D

_LEAST_PX = 1e-3
"""Transmission below which a blob ends, so that it has borders."""


def blobs(size: int, seed: int) -> Floats:
    """Two smooth blobs that overlap, of radii (one sigma) between 4 and 7 px, cut where they are below a thousandth."""
    rng = np.random.default_rng(seed)
    row, column = np.mgrid[:size, :size]
    image = np.zeros((size, size))
    for _ in range(2):
        x, y = 30 + 10 * rng.random(2)
        wide, high = 4 + 3 * rng.random(2)
        image += (0.3 + 0.7 * rng.random()) * np.exp(-(((column - x) / wide) ** 2 + ((row - y) / high) ** 2) / 2)
    image /= image.max()
    return np.where(image > _LEAST_PX, image, 0.0)


def letter(size: int, name: str, height_px: int) -> Floats:
    """A letter in the upper left corner."""
    cells = BUILT_INS[name](height_px).cells
    image = np.zeros((size, size))
    image[: cells.shape[0], : cells.shape[1]] = cells
    return image


@dataclass(frozen=True, eq=False)
class Scene:
    """An object and its motion."""

    image: Floats
    """``(m, m)`` transmission at displacement 0."""

    path: Path2D
    """Displacement over seconds."""

    label: str
    """What a failing example is called."""

    def __repr__(self) -> str:
        """Name the example."""
        return self.label


@st.composite
def scenes(draw: st.DrawFn, size: int, run_s: float) -> Scene:
    """Draw an object and a smooth motion of it through the field: a gentle curve from place to place, and one slow swing."""
    kind = draw(st.sampled_from(["blobs", "letter-B"]))
    if kind == "blobs":
        seed = draw(st.integers(0, 10**6))
        image, kind = blobs(size, seed), f"blobs {seed}"
    else:
        height_px = draw(st.integers(30, 40))
        image, kind = letter(size, kind, height_px), f"{kind} of {height_px} px"
    low, high = _room(image)
    swing = draw(st.floats(0, 4))
    numbers = [draw(st.floats(0, 1)) for _ in range(4)]
    start, end = (low + swing + (high - low - 2 * swing) * np.array(numbers[k : k + 2]) for k in (0, 2))

    def path(time_s: Floats) -> Floats:
        part = (time_s / run_s)[:, None]
        smooth: Floats = start + (end - start) * (3 * part**2 - 2 * part**3) + swing * np.sin(2 * np.pi * part)
        return smooth

    return Scene(image, path, f"{kind} from {start.round(3).tolist()} to {end.round(3).tolist()}, swing {swing:g}")


def _room(image: Floats) -> tuple[Floats, Floats]:
    """Least and largest displacement, x and y, at which the object is still inside."""
    rows, columns = np.flatnonzero(image.any(axis=1)), np.flatnonzero(image.any(axis=0))
    size = len(image) - 1
    low = np.array([-columns[0], -rows[0]], np.float64)
    return low, np.array([size - columns[-1], size - rows[-1]], np.float64)
