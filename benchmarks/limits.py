"""The Cramer-Rao limit of displacement, for the image given: no tracker without other knowledge does better, image or not.

A frame's six values have means mu(x, y) and independent noise of variance v: its information on (x, y) is the sum of
(d mu)(d mu)' / v. The limit of a frame by itself is the inverse of that. The limit of a whole path that is a polynomial in time
follows from the information of all frames on its coefficients; displacement is counted from frame 0, as everywhere.

References:
    Kay, "Fundamentals of Statistical Signal Processing: Estimation Theory" (1993), chapter 3.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.scenes import Path2D, recorded
from instrument.plan import Plan
from protocols import Floats

_STEP_PX = 0.5


@dataclass(frozen=True)
class Limits:
    """Mean squared errors, px^2, mean of both axes."""

    frame_px2: float
    """Of each frame by itself, against a known reference."""

    path_px2: float
    """Of a polynomial path from all frames together, relative to frame 0."""


def cramer_rao(
    plan: Plan, image: Floats, path: Path2D, *, frames: int, degree: int, sigma: float, peak_counts: float | None
) -> Limits:
    """Work out the limits.

    Args:
        plan: of the run.
        image: ``(m, m)`` transmission.
        path: of the object.
        frames: how many of the plan's are used.
        degree: of the polynomial that the path is known to be, along each axis.
        sigma: of noise ``pixel``.
        peak_counts: photons of an all-on pattern instead.
    """
    steps = [np.array(step) * _STEP_PX for step in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))]
    moved = [recorded(plan, image, lambda t, s=step: path(t) + s).values[:frames] for step in steps]
    scale = 1.0 if peak_counts is None else peak_counts / float(image.sum())
    slopes = scale * np.stack([moved[0] - moved[1], moved[2] - moved[3]], axis=-1) / (2 * _STEP_PX)
    if peak_counts is None:
        lit = 0.5 * plan.image_size**2  # of each pattern, but for the first Hadamard pair
        variance = np.full(slopes.shape[:2], sigma**2 * lit)
    else:
        variance = np.maximum(scale * np.mean(moved, axis=0), 1e-9)
    information: Floats = np.einsum("fka,fkb,fk->fab", slopes, slopes, 1 / variance)
    base = np.asarray(np.polynomial.legendre.legvander(np.linspace(-1, 1, frames), degree), np.float64)
    whole = np.einsum("fi,fab,fj->aibj", base, information, base).reshape(2 * (degree + 1), -1)
    covariance: Floats = np.asarray(np.linalg.inv(whole), np.float64).reshape(2, degree + 1, 2, degree + 1)
    step = base - base[0]
    path_px2 = np.mean([np.einsum("fi,ij,fj->f", step, covariance[a, :, a], step).mean() for a in range(2)])
    alone = np.asarray(np.linalg.inv(information), np.float64)
    return Limits(float(np.median(alone[:, 0, 0] + alone[:, 1, 1]) / 2), float(path_px2))
