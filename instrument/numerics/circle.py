"""A circle through points that lie on an arc of it."""

from dataclasses import dataclass

import numpy as np

from protocols import Floats


@dataclass(frozen=True, eq=False)
class Circle:
    """A circle, and how well its centre is known."""

    centre: Floats
    """``(2,)``."""

    radius: float
    """Radius."""

    covariance: Floats
    """``(2, 2)``: of the centre, from the scatter of the points about the circle."""

    scatter: float
    """Standard deviation of the points' distances from the circle."""

    leverage: Floats
    """``(2, 2)``: covariance of the centre for an error of standard deviation 1 that is the same for all points of a place."""

    turned_rad: float
    """Angle between the two points farthest apart along the circle, as the points follow each other."""


def fit_circle(points: Floats) -> Circle | None:
    """Fit a circle by least squares of the points' distances from it; None where they do not make a circle.

    The scatter need not be independent from point to point: where neighbours deviate alike, fewer points count.

    Args:
        points: ``(n, 2)`` in the order in which they were measured, at least four.

    References:
        N. Chernov, "Circular and Linear Regression" (2010), chapters 4 and 5: geometric fit from Kasa's algebraic one.
    """
    if len(points) < 4:
        return None
    middle = points.mean(axis=0)
    about = points - middle
    design = np.column_stack([2 * about, np.ones(len(about))])
    squares = (about**2).sum(axis=1)
    if np.linalg.matrix_rank(design, rtol=1e-8) < design.shape[1]:
        return None
    algebraic: Floats = np.asarray(np.linalg.solve(design.T @ design, design.T @ squares), np.float64)
    start = np.append(algebraic[:2], np.sqrt(max(float(algebraic[2] + algebraic[:2] @ algebraic[:2]), 0.0)))

    def distances(circle: Floats) -> Floats:
        return np.asarray(np.hypot(*(about - circle[:2]).T) - circle[2], np.float64)

    from scipy.optimize import least_squares  # noqa: PLC0415 - slow to load: not while a counter counts

    fit = least_squares(distances, start, method="lm", max_nfev=200)
    jacobian = np.asarray(fit.jac, np.float64)
    information = jacobian.T @ jacobian
    if not fit.success or np.linalg.cond(information) > 1e12:
        return None
    variance = 2 * float(fit.cost) / max(len(points) - 3, 1)
    of_white = np.asarray(np.linalg.inv(information)[:2, :2], np.float64)
    covariance = of_white * variance * _points_that_say_the_same(np.asarray(fit.fun, np.float64))
    turned_rad = float(np.ptp(np.unwrap(np.arctan2(*(about - fit.x[:2]).T[::-1]))))
    return Circle(
        centre=np.asarray(fit.x[:2] + middle, np.float64),
        radius=abs(float(fit.x[2])),
        covariance=covariance,
        scatter=float(np.sqrt(variance)),
        leverage=of_white * len(points),
        turned_rad=turned_rad,
    )


def _points_that_say_the_same(deviation: Floats) -> float:
    """Give 1 + 2 times the sum of the deviations' correlations over lags, as far as they are positive; 1 for white noise."""
    about = deviation - deviation.mean()
    power = float(about @ about)
    together = 1.0
    for lag in range(1, len(about) // 4):
        correlation = float(about[lag:] @ about[:-lag]) / max(power, 1e-300)
        if correlation <= 2 / np.sqrt(len(about)):
            break
        together += 2 * correlation
    return together
