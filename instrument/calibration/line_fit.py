"""Weighted regression of image places on stage positions: scale, axis, backlash, and what is left."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from protocols import Floats

_AXES: Final = 2


@dataclass(frozen=True, eq=False)
class LineFit:
    """place = offset + slope * position + half the backlash's shift, to one side or the other."""

    px_per_mm: Floats
    """``(2,)``: slope along x and y."""

    covariance: Floats
    """``(2, 2)``: its covariance, enlarged where the residuals are larger than the places' own uncertainties."""

    backlash_mm: float | None
    """Position told on the way up minus that on the way down for the same place; None where all came from one side."""

    backlash_sigma_mm: float | None
    """Standard uncertainty of that."""

    offset_px: Floats
    """``(2,)``: place at position 0, in the middle between both approaches."""

    residual_px: Floats
    """``(n, 2)``: places minus the fit."""

    scatter: float
    """Root of chi-square over its degrees of freedom: 1 where the residuals are as large as the places' uncertainties say."""

    degrees_of_freedom: int | None
    """Behind the covariance, where it was enlarged; None where the places' own uncertainties made it."""


def fit_line(position_mm: Floats, upward: Floats, place_px: Floats, covariance_px2: Floats) -> LineFit:
    """Fit places to positions.

    Args:
        position_mm: ``(n,)`` told by the stage, two different ones at least.
        upward: ``(n,)`` +1 where it came from below, -1 where from above.
        place_px: ``(n, 2)`` x and y, 0 anywhere.
        covariance_px2: ``(n, 2, 2)`` of each place; places are independent.
    """
    count = len(position_mm)
    both = bool(np.ptp(upward))
    middle_mm = float(position_mm.mean())
    columns = [np.ones(count), position_mm - middle_mm, *([upward / 2] if both else [])]
    # One regression of both axes: rows x0, y0, x1, y1, ...; unknowns by axis.
    design: Floats = np.asarray(np.kron(np.stack(columns, axis=1), np.eye(_AXES)), np.float64)
    roots = np.linalg.cholesky(np.linalg.inv(covariance_px2))
    whitened: Floats = np.einsum("nba,nbk->nak", roots, design.reshape(count, _AXES, -1)).reshape(count * _AXES, -1)
    target: Floats = np.einsum("nba,nb->na", roots, place_px).ravel()
    inverse: Floats = np.asarray(np.linalg.inv(whitened.T @ whitened), np.float64)
    found = inverse @ (whitened.T @ target)
    residual = target - whitened @ found
    freedom = len(target) - len(found)
    scatter = float(np.sqrt(residual @ residual / freedom)) if freedom > 0 else 1.0
    inverse = inverse * max(1.0, scatter) ** 2
    slope, of_slope = found[_AXES : 2 * _AXES], inverse[_AXES : 2 * _AXES, _AXES : 2 * _AXES]
    backlash, backlash_sigma = (None, None)
    if both:
        scale = float(np.hypot(*slope))
        axis = slope / scale
        backlash = -float(axis @ found[2 * _AXES :]) / scale
        backlash_sigma = float(np.sqrt(axis @ inverse[2 * _AXES :, 2 * _AXES :] @ axis)) / scale
    return LineFit(
        px_per_mm=slope,
        covariance=of_slope,
        backlash_mm=backlash,
        backlash_sigma_mm=backlash_sigma,
        offset_px=found[:_AXES] - slope * middle_mm,
        residual_px=place_px - (design @ found).reshape(count, _AXES),
        scatter=scatter,
        degrees_of_freedom=freedom if scatter > 1 else None,
    )
