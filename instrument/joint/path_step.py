"""One Gauss-Newton step of the path, with image and light held, and how sure the path is then.

The stated variance is that of the smoothed path, enlarged where the values show errors that are slower than noise: in the
amplitude of the position signals, which no motion changes, and in the steps that the Hadamard values still ask for.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from instrument.joint.evidence import Evidence, View
from instrument.numerics import Smooth, smooth
from instrument.tracking import Trajectory
from protocols import Floats, Integers

_LEAST_INFORMATION: Final = 1e-3
"""Over the best frame's: a frame with less information makes a smaller step of its own."""

_BLOCK_FRAMES: Final = 50
"""In a block of which slow errors are seen: some pixels of path, longer than an error of the dithering."""

_BLOCKS: Final = (8, 32)
"""Fewest and most blocks in a run."""

_TINY: Final = 1e-12


@dataclass(frozen=True, eq=False)
class PathStep:
    """What a step led to."""

    trajectory: Trajectory
    """The path."""

    fits: tuple[Smooth, ...]
    """How it was smoothed, along x and y; none where the path was kept."""


def path_step(evidence: Evidence, frame: Integers, last: Trajectory) -> PathStep:
    """Make one Gauss-Newton step for x and then, with that made, one for y, each smoothed over the whole run.

    The Fisher information of a frame is the sum of its squared slopes, and its score that of slope times residual, as both are
    in units of the noise.

    Args:
        evidence: residuals and slopes at the last path.
        frame: ``(rows,)`` index of each valid frame.
        last: the path so far.

    Returns:
        The refined path; the last one where the image is too dark to say anything of it along one axis.
    """
    step_px = np.zeros((len(frame), 2))
    fits: list[Smooth] = []
    inflation: list[float] = []
    for axis in range(2):
        last_px = last.displacement_px[:, axis]
        information, score = np.zeros(len(last)), np.zeros(len(last))
        for view in evidence.views:
            residual = view.residual - np.vecdot(view.slope[:, :2], step_px)
            information[frame] += view.slope[:, axis] ** 2
            score[frame] += view.slope[:, axis] * residual
        if not (information > 0).any():
            return PathStep(last, ())  # nothing is to be seen along this axis
        target_px = last_px + score / np.maximum(information, _LEAST_INFORMATION * information.max())
        fit = smooth(target_px, information, absolute_weights=True)
        step_px[:, axis] = (fit.values - last_px)[frame]
        fits.append(fit)
        own = evidence.axes[axis]
        share = float(np.sum(own.position.slope[:, axis] ** 2) / information.sum())
        amplitude, steps = 1.0, _slow_step_ratio(evidence.hadamard, axis)
        if own.amplitude is not None:  # which tells already, so that here only what is no chance counts
            amplitude = _slow_error_ratio(own.amplitude)
            steps = max(1.0, steps - (2 / len(_in_blocks(own.amplitude))) ** 0.5)
        inflation.append(1 + share * (amplitude - 1) + (1 - share) * (steps - 1))
    place_px = np.stack([fit.values for fit in fits], axis=1)
    origin = last.reference_frame
    variance_px2 = np.stack([fit.variance_to(origin) for fit in fits], axis=1) * np.array(inflation)
    sigma_px = np.sqrt(variance_px2)
    path = replace(
        last, displacement_px=place_px - place_px[origin], sigma_px=sigma_px, method="joint", covariance=None
    )
    return PathStep(path, tuple(fits))


def _slow_error_ratio(amplitude: Floats) -> float:
    """Give the variance of an amplitude's means over blocks, relative to that of white noise of variance 1; at least 1."""
    blocks = _in_blocks(amplitude)
    frames = int(blocks.shape[1])
    return max(1.0, float(blocks.mean(axis=1).var(ddof=1)) * frames)


def _slow_step_ratio(view: View, axis: int) -> float:
    """Give the variance of the step that each block of frames asks for along an axis, relative to that of its noise; at least 1.

    Where path and image are right, the residuals are noise, and each block asks for a step as large as its information allows:
    the square of the step over its variance is 1 in the mean (a reduced chi-square over blocks).
    """
    slope = view.slope[:, axis]
    score: Floats = _in_blocks(slope * view.residual).sum(axis=1)
    information: Floats = _in_blocks(slope**2).sum(axis=1)
    return max(1.0, float(np.mean(score**2 / np.maximum(information, _TINY))))


def _in_blocks(series: Floats) -> Floats:
    """``(blocks, frames)``: a series cut into blocks in which errors are slow; what is left at its end is left out."""
    fewest, most = _BLOCKS
    frames = max(2, len(series) // min(max(len(series) // _BLOCK_FRAMES, fewest), most))
    return series[: len(series) // frames * frames].reshape(-1, frames)
