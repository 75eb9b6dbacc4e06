"""One Gauss-Newton step of angle and magnification, with the image held.

The Hadamard values alone decide: what position patterns see of a shape is mostly their dithering. Both numbers are low
polynomials of time: a line, and a bend where the values ask for it. A constant says how the object stands in the image, which
the image itself is free to follow, so that the step leaves it out. A change of path leads to residuals that are partly alike:
the regression has a slow one among its unknowns too, and the path takes its own step afterwards.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.polynomial.legendre import legvander

from instrument.joint.evidence import Evidence, View
from instrument.tracking import Trajectory
from protocols import Floats, Integers

HIGHEST_DEGREE: Final = 2
"""Of the polynomials of time that angle and logarithm of the magnification are."""

_WIDENED: Final = 1.4
"""Factor on the standard deviations of the noise alone, as the image that is held is in error too: angle and magnification of
runs with other noise and at other places are off by so much more (docs/explanation/shape.md)."""

_TINY: Final = 1e-12


@dataclass(frozen=True, eq=False)
class ShapeStep:
    """What a step led to."""

    evidence: Evidence
    """What is left of the residuals."""

    trajectory: Trajectory
    """The path with the new shape, against that at its reference frame."""

    over_sigma: float
    """Change of angle and magnification over their uncertainty, both rms; the larger of both."""


@dataclass(frozen=True, eq=False)
class ShapeFit:
    """What residuals say of a change of shape."""

    line: Floats
    """``(2,)``: coefficients of the lines, of angle in radians and of the logarithm of the magnification: half their change."""

    covariance: Floats
    """``(2, 2)``: their covariance by the noise."""

    change: Floats
    """``(frames, 2)``: the polynomials, lines and bends."""

    variance: Floats
    """``(frames, 2)``: variance of their change since a frame, by the scatter of the residuals where that is more than noise."""

    scatter: float
    """Mean square of what they leave of the residuals."""

    @property
    def significance(self) -> float:
        """Chi-square of both lines together, of two degrees of freedom, with the scatter of the residuals for their noise."""
        chi_square = float(self.line @ np.linalg.solve(self.covariance, self.line))
        return chi_square / max(1.0, self.scatter)


def reshaped(evidence: Evidence, frame: Integers, last: Trajectory) -> ShapeStep:
    """Make a step.

    Args:
        evidence: residuals and slopes at the last path and shape.
        frame: ``(rows,)`` index of each valid frame.
        last: path and shape so far.
    """
    seen, origin = evidence.hadamard, last.reference_frame
    fit = shape_fit(seen.residual, seen.slope, frame, len(last), origin)
    sigma, change = _WIDENED * np.sqrt(fit.variance), fit.change
    left = View(seen.residual - np.vecdot(seen.slope[:, 2:], change[frame]), seen.slope)
    angle = np.zeros(len(last)) if last.angle_deg is None else last.angle_deg
    magnification = np.ones(len(last)) if last.magnification is None else last.magnification
    magnification = magnification * np.exp(change[:, 1] - change[origin, 1])
    trajectory = replace(
        last,
        angle_deg=angle + np.rad2deg(change[:, 0] - change[origin, 0]),
        angle_sigma_deg=np.rad2deg(sigma[:, 0]),
        magnification=magnification,
        magnification_sigma=magnification * sigma[:, 1],
    )
    over = np.sqrt(np.mean(change**2, axis=0) / np.maximum(np.mean(fit.variance, axis=0), _TINY))
    return ShapeStep(replace(evidence, hadamard=left), trajectory, float(over.max()))


def shape_fit(residual: Floats, slope: Floats, frame: Integers, frames: int, origin: int = 0) -> ShapeFit:
    """Fit polynomials of time to residuals.

    A bend is taken where it explains the residuals better by more than what a chance one would (Schwarz's criterion).

    Args:
        residual: ``(n,)`` in units of the noise.
        slope: ``(n, 4)`` derivatives by x, y, angle and logarithm of the magnification, likewise.
        frame: ``(n,)`` index of each one's frame.
        frames: of the run.
        origin: frame that changes count from.

    References:
        G. Schwarz, Annals of Statistics 6 (1978) 461.
    """
    powers = np.asarray(legvander(np.linspace(-1.0, 1.0, frames), HIGHEST_DEGREE), np.float64)
    fits = [
        _of_degree(residual, slope, frame, powers, degree, origin=origin) for degree in range(1, HIGHEST_DEGREE + 1)
    ]
    price = 2 * float(np.log(len(residual)))
    scores = [len(residual) * np.log(fit.scatter + _TINY) + price * degree for degree, fit in enumerate(fits, 1)]
    return fits[int(np.argmin(scores))]


def _of_degree(
    residual: Floats, slope: Floats, frame: Integers, powers: Floats, degree: int, *, origin: int
) -> ShapeFit:
    """Fit a path of the highest degree, and a shape of one degree, to residuals.

    Args:
        residual: as in ``shape_fit``.
        slope: likewise.
        frame: likewise.
        powers: ``(frames, highest degree + 1)`` polynomials of time.
        degree: of angle and logarithm of the magnification.
        origin: as in ``shape_fit``.
    """
    path, shape = slope[:, :2, None] * powers[frame, None, :], slope[:, 2:, None] * powers[frame, None, : degree + 1]
    design = np.hstack([shape.reshape(len(slope), -1), path.reshape(len(slope), -1)])
    size = np.linalg.norm(design, axis=0) + _TINY
    inverse = np.linalg.pinv(design.T @ design / np.outer(size, size)) / np.outer(size, size)
    found = inverse @ (design.T @ residual)
    own = (2, degree + 1)
    of_shape, covariance = found[: 2 * own[1]].reshape(own), inverse[: 2 * own[1], : 2 * own[1]].reshape(own + own)
    since = powers[:, 1 : degree + 1] - powers[origin, 1 : degree + 1]
    variances = [np.einsum("fp,pq,fq->f", since, covariance[k, 1:, k, 1:], since) for k in range(2)]
    scatter = float(np.mean((residual - design @ found) ** 2))
    return ShapeFit(
        line=of_shape[:, 1],
        covariance=covariance[:, 1, :, 1],
        change=powers[:, 1 : degree + 1] @ of_shape[:, 1:].T,
        variance=max(1.0, scatter) * np.stack(variances, axis=1),
        scatter=scatter,
    )
