"""An object that slowly turns or grows while it moves: noticed, followed, and told.

A rigid image of such an object is blurred, but explains nearly all the same: 3 degrees in a run raise the misfit by two
hundredths, less than it varies from one object to another. What is left unexplained is therefore held against what a turn or
a growth would change: lines of angle and magnification over time are fitted to the residuals of the Hadamard values, with the
image held. Where they are significant, image, shape and path are refined in turn, and kept if that explains significantly
more.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from instrument.joint.detail import Picture
from instrument.joint.iterate import Iterate
from instrument.joint.rounds import FEWEST_FRAMES, refined
from instrument.joint.shape_step import ShapeFit, shape_fit
from instrument.measurement import Finding
from instrument.reconstruction import Region, binned
from instrument.tracking import Trajectory
from protocols import Floats, Singles

_NOTICED: Final = 14.0
"""Chi-square of two degrees of freedom from which on a change is looked into: chance reaches it in one run of 1,100. Rigid
objects left 0 to 6; 3 degrees at a noise of 0.1, 20 to 61."""

_BELIEVED: Final = 12.0
"""Fall of the sum of squared residuals, over the noise, from which on it is believed."""

_TOLD: Final = 3.0
"""Standard deviations, as stated, from which on a turn or a growth is told."""

_COARSE: Final = 0.1
"""Uncertainty in degrees or % from which on one digit after the point says all, and not two."""

_LIT: Final = 0.15
"""Part of the brightest pixel from which on a pixel is the object's, for its centroid and for what a change of shape would do."""

_FAINT: Final = 0.05
"""Part of the brightest pixel from which on a pixel may be the object's,"""

_MARGIN_PX: Final = 8
"""with as many pixels around: nothing else is looked at."""

_ENTRIES: Final = 1 << 27
"""Entries of a matrix at most: half a gigabyte. Beyond, the image keeps to the patterns' grid, or the shape is not followed."""

_TINY: Final = 1e-12

_FOLLOWED: Final = (
    "path and image follow it, and the displacement is that of its centroid; a stage that yaws, or a way out of the plane of "
    "focus, does that"
)


def changing(rigid: Picture, *, asked: bool, fitted: bool) -> Picture | None:
    """Follow the shape of an object; None where it does not change, as far as the values show.

    Args:
        rigid: path, and image of the object as if it were rigid.
        asked: whether it is followed whatever the values show.
        fitted: whether the light model is fitted to the run.

    Returns:
        Path, image and shape. The measurement tells the change as a finding.
    """
    iterate = rigid.iterate
    image = binned(rigid.state.image.astype(np.float64), iterate.problem.field.grid).astype(np.float32)
    rows = len(iterate.problem.values)
    if rows < FEWEST_FRAMES or not (image > 0).any():
        return None
    region = iterate.problem.region
    start = iterate.on_grid(1).about(_centroid_px(image, region))
    if not asked and _unexplained(start, image, rigid).significance < _NOTICED:
        return None
    near = _around(region, image)
    start = start.within(near)
    entries = rows * start.problem.region.height * start.problem.region.width
    if entries > _ENTRIES:
        text = "the object turns or grows" if not asked else "the object's shape was not followed"
        return replace(rigid, iterate=_told(iterate, text, f"{rows} frames are too many to follow it: analyse fewer"))
    strength = rigid.strength
    refinement = refined(start, None, fitted=fitted, strength=strength)
    grid = iterate.problem.field.grid
    found = refinement.iterate.on_grid(grid if entries * grid**2 <= _ENTRIES else 1)
    picture = Picture.of(found, strength)
    if not asked:  # against a rigid image of no more pixels, which could explain more of the noise
        alike = Picture.of(iterate.within(near).on_grid(found.problem.field.grid), strength)
        if rows * (alike.state.misfit**2 - picture.state.misfit**2) < _BELIEVED:
            return None
    return replace(picture, iterate=_told(found, change_text(found.trajectory), _FOLLOWED))


def change_text(trajectory: Trajectory) -> str:
    """Say how an object turned and grew: what is significant, or both where nothing is."""
    told: dict[str, float] = {}
    if trajectory.angle_deg is not None and trajectory.angle_sigma_deg is not None:
        turn, sigma = float(trajectory.angle_deg[-1]), float(trajectory.angle_sigma_deg[-1])
        told[f"turned by {_with_sigma(turn, sigma)} degrees"] = abs(turn) / max(sigma, _TINY)
    if trajectory.magnification is not None and trajectory.magnification_sigma is not None:
        growth, sigma = 100 * float(trajectory.magnification[-1] - 1), 100 * float(trajectory.magnification_sigma[-1])
        told[f"grew by {_with_sigma(growth, sigma)} %"] = abs(growth) / max(sigma, _TINY)
    significant = [text for text, over_sigma in told.items() if over_sigma >= _TOLD]
    return f"the object {' and '.join(significant or told)} in the run"


def _with_sigma(value: float, sigma: float) -> str:
    """Give a number with its uncertainty, to the digit that means something."""
    digits = 1 if sigma >= _COARSE else 2
    return f"{value:+.{digits}f} +- {sigma:.{digits}f}"


def _told(iterate: Iterate, text: str, why: str) -> Iterate:
    """Tell it with the measurement."""
    frames = tuple(range(len(iterate.trajectory)))
    finding = Finding("changes shape", frames, text, f"{text}: {why}")
    measurement = iterate.measurement
    return replace(iterate, measurement=replace(measurement, findings=(*measurement.findings, finding)))


def _unexplained(start: Iterate, image: Singles, rigid: Picture) -> ShapeFit:
    """Hold what a rigid image leaves unexplained against a change of shape.

    Args:
        start: the same path on the patterns' grid, about the centroid.
        image: the rigid image there.
        rigid: the rigid image as it was found, which explains most.
    """
    problem = rigid.iterate.problem
    operator, whitened = problem.hadamard()
    residual = whitened - operator.matvec(np.concatenate([part.ravel() for part in rigid.state.images]))
    values, slopes = start.problem.turned_rows().values(np.where(image > _LIT * image.max(), image, np.float32(0)))
    if problem.steady:
        slopes[:, 3] -= 2 * values  # at the same light
    slopes /= problem.values.difference_sigma[:, None]
    return shape_fit(residual.astype(np.float64), slopes, problem.values.frame, len(rigid.iterate.trajectory))


def _centroid_px(image: Singles, region: Region) -> Floats:
    """Give the centroid of what is lit, ``(2,)`` x and y in the field."""
    lit = np.where(image > _LIT * image.max(), image, 0.0).astype(np.float64)
    across, down = lit.sum(axis=0), lit.sum(axis=1)
    x, y = (float(light @ np.arange(len(light)) / light.sum()) for light in (across, down))
    return np.array([region.left + x, region.top + y])


def _around(region: Region, image: Singles) -> Region:
    """Give the rectangle around what an image of a region shows, with a margin."""
    lit = image > _FAINT * image.max()
    rows, columns = np.flatnonzero(lit.any(axis=1)), np.flatnonzero(lit.any(axis=0))
    top, left = max(0, int(rows[0]) - _MARGIN_PX), max(0, int(columns[0]) - _MARGIN_PX)
    bottom = min(region.height, int(rows[-1]) + 1 + _MARGIN_PX)
    right = min(region.width, int(columns[-1]) + 1 + _MARGIN_PX)
    return Region(region.top + top, region.left + left, bottom - top, right - left)
