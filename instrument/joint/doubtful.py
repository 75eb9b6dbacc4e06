"""What makes a refined path uncertain beside the noise: offsets that are only estimated, and light that may be uneven.

Both move positions by an amount that follows the place of the object, too slowly to be smoothed, and neither is seen in the
residuals: the path agrees with them.
"""

from typing import Final

import numpy as np
from numpy.polynomial import chebyshev

from instrument.joint.evidence import Evidence
from instrument.tracking import Trajectory
from protocols import Floats, Integers, Singles

_FLAT: Final = 0.3
"""Slope of a value, over the typical one, that is taken at least where an error of the value is turned into one of the place."""

_DEGREE: Final = 3
"""Degree of the polynomial by which the light is taken to change with time: what is faster is the lamp's."""

_LEAST_PX: Final = 4.0
"""Length of the path below which no gradient of the light is seen."""

_RESTS: Final = 0.2
"""Speed over the mean one below which an object nearly rests: light that changes there is the lamp's."""

_CERTAIN: Final = 16.0
"""Square of a change of the gradient, over its variance by noise, without which the light is taken to be even,"""

_CHANCE: Final = 4.0
"""and what of it is taken for chance all the same."""

_TINY: Final = 1e-12


def of_offsets(evidence: Evidence, covariance: Floats, frame: Integers, path: Trajectory) -> Floats:
    """``(frames, 2)``: variance of the displacements by the uncertainty of the position values' offsets.

    Args:
        evidence: what the values say of the displacement.
        covariance: ``(k, k)`` of the offsets, over the total light.
        frame: ``(rows,)`` index of each valid frame.
        path: of all frames.
    """
    found = np.zeros((len(path), 2))
    origin = min(int(np.searchsorted(frame, path.reference_frame)), len(frame) - 1)
    for axis, own in enumerate(evidence.axes):
        slope = own.position.slope[:, axis]
        information = sum(float(np.sum(view.slope[:, axis] ** 2)) for view in evidence.views)
        if own.by_offset.shape[1] != len(covariance) or information <= 0:
            continue
        share = float(np.sum(slope**2)) / information
        least = _FLAT * float(np.sqrt(np.mean(slope**2))) + _TINY
        moved = share * own.by_offset / (np.where(slope < 0, -1, 1) * np.maximum(np.abs(slope), least))[:, None]
        since = moved - moved[origin]
        variance = np.maximum(np.einsum("rk,kl,rl->r", since, covariance, since), 0.0)
        found[:, axis] = np.interp(np.arange(len(path)), frame, variance)
    return found


def of_uneven_light(total: Floats, trajectory: Trajectory, image: Singles, grid: int) -> Floats:
    """``(frames, 2)``: variance of the displacements if the light changes because the field is not evenly lit.

    The total light does not tell whether the lamp changes or the field is brighter where the object comes to. A lamp moves
    nothing. But where the field is brighter to one side of the object, that side counts for more, and the object seems to be
    there: by the relative gradient of the light times the variance of the object's light about its middle. What that changes
    since the path's reference frame may be an error of the displacement.

    Args:
        total: ``(frames,)`` total light, not divided by the lamp; NaN where it is not known.
        trajectory: path of the object.
        image: its image.
        grid: image pixels a pattern pixel.
    """
    frames = len(trajectory)
    known = np.isfinite(total) & trajectory.valid
    steps_px = np.hypot(*np.diff(trajectory.displacement_px, axis=0, prepend=trajectory.displacement_px[:1]).T)
    length_px = np.cumsum(steps_px)
    if length_px[-1] < _LEAST_PX or np.count_nonzero(known) <= _DEGREE + 1 or not image.sum() > 0:
        return np.zeros((frames, 2))
    place = np.linspace(-1, 1, frames)
    powers = chebyshev.chebvander(place, _DEGREE)
    covariance = np.linalg.inv(powers[known].T @ powers[known])
    fit = covariance @ (powers[known].T @ total[known])
    light: Floats = powers @ fit
    if not (light > 0).all():
        return np.zeros((frames, 2))
    noise = float(np.mean((total[known] - light[known]) ** 2))
    along_px = np.asarray(chebyshev.chebval(place, chebyshev.chebfit(place, length_px, _DEGREE)), np.float64)
    speed_px = np.gradient(along_px)
    least = _RESTS * float(length_px[-1]) / frames
    # Over the mean light and not that of the moment, so that a lamp which drifts evenly with the path makes nothing uncertain.
    slopes = np.gradient(powers, axis=0) / (light.mean() * np.maximum(speed_px, least))[:, None]
    since = slopes - slopes[trajectory.reference_frame]  # derivative of the gradient's change by the coefficients
    by_chance = noise * np.einsum("fp,pq,fq->f", since, covariance, since)
    changed = (since @ fit) ** 2
    if not (changed > _CERTAIN * by_chance + _TINY).any():
        return np.zeros((frames, 2))
    changed = np.maximum(changed - _CHANCE * by_chance, 0.0)
    return np.asarray(changed[:, None] * spread_px2(image, grid) ** 2, np.float64)


def spread_px2(image: Singles, grid: int) -> Floats:
    """``(2,)``: variance of an image's light about its middle along x and y, in px^2 of the patterns."""
    light = np.maximum(image.astype(np.float64), 0.0)
    found: list[float] = []
    for axis in (0, 1):
        profile = light.sum(axis=axis)
        at = np.arange(len(profile)) / grid
        middle = float(profile @ at) / float(profile.sum())
        found.append(float(profile @ (at - middle) ** 2) / float(profile.sum()))
    return np.array(found)
