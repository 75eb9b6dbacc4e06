"""A run computed straight from the formulas: an oracle for tracking and reconstruction that shares no code with the bench.

The object is made of square pixels, so a sub-pixel shift is linear interpolation, exactly.
"""

from collections.abc import Callable

import numpy as np

from instrument.plan import Plan
from instrument.recording import Recording
from instrument.schemes import scheme_of
from protocols import Floats, Truth

Path2D = Callable[[Floats], Floats]
"""Seconds ``(n,)`` to displacement ``(n, 2)`` in x, y pixels."""


def shifted(image: Floats, dx: float, dy: float) -> Floats:
    """Move an image by (dx, dy) px, zero from outside: O(x - dx, y - dy)."""
    size = len(image)
    ix, iy = int(np.floor(dx)), int(np.floor(dy))
    fx, fy = dx - ix, dy - iy
    pad = size + 2
    wide = np.zeros((size + 2 * pad, size + 2 * pad))
    wide[pad : pad + size, pad : pad + size] = image

    def cut(oy: int, ox: int) -> Floats:
        return wide[pad - iy - oy : pad - iy - oy + size, pad - ix - ox : pad - ix - ox + size]

    return (1 - fy) * ((1 - fx) * cut(0, 0) + fx * cut(0, 1)) + fy * ((1 - fx) * cut(1, 0) + fx * cut(1, 1))


def simulate(
    plan: Plan,
    image: Floats,
    path: Path2D,
    *,
    sigma: float = 0.0,
    peak_counts: float | None = None,
    seed: int = 0,
) -> Recording:
    """Record ``image`` moved along ``path``, each pattern at its own time.

    Args:
        plan: what is shown.
        image: ``(m, m)`` transmission at displacement 0.
        path: displacement over time; the truth is stated relative to frame 0's middle.
        sigma: ``pixel`` noise: sigma * sqrt(lit pixels) on every value.
        peak_counts: photon counting instead: counts of an all-on pattern.
        seed: of the noise.
    """
    sequence = scheme_of(plan).sequence()
    scale = sequence.samples // plan.image_size
    weights = np.stack(
        [
            sequence.sample_plane(k).reshape(plan.image_size, scale, plan.image_size, scale).mean(axis=(1, 3))
            for k in range(len(sequence.planes))
        ]
    )
    play = sequence.play_order[:-1]
    time_s = (np.arange(len(play), dtype=np.float64) + 0.5) * plan.picture_time_s
    places = path(time_s)
    values = np.array([np.vdot(shifted(image, dx, dy), weights[k]) for k, (dx, dy) in zip(play, places, strict=True)])
    rng = np.random.default_rng(seed)
    if peak_counts is not None:
        values = rng.poisson(values * peak_counts / image.sum()).astype(np.float64)
    elif sigma:
        values += rng.normal(size=len(values)) * sigma * np.sqrt(weights.sum(axis=(1, 2))[play])
    middle = path((np.arange(plan.frames, dtype=np.float64) + 0.5) * 6 * plan.picture_time_s)
    start = path(np.array([3 * plan.picture_time_s]))[0]
    return Recording(
        plan=plan,
        values=values.reshape(plan.frames, 6),
        frame_valid=np.ones(plan.frames, bool),
        picture_time_s=plan.picture_time_s,
        photon_counts=peak_counts is not None,
        truth=Truth(displacement_px=middle - start, image=shifted(image, *start)),
    )
