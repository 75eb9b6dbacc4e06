"""Dead time, and of which kind, from pictures whose light adds up.

The field is cut into K parts. Pictures light one part, two, four, or all of them, and the light of a picture is the sum of
the light of its parts, whatever the object and the illumination are. What a detector counts of it falls short of the sum,
the more the brighter the picture is, and by how much says the dead time: n photons a second give m = n / (1 + n tau) counts,
or n exp(-n tau) where a photon in the dead time prolongs it. Both lose n tau at first; they differ by n^2 tau^2 / 2, which
takes more counts to see.

Two things do not add up by themselves and are fitted too: light that comes whatever the picture is (dark counts and stray
light), and light that is lost at the borders between lit and dark mirrors. The latter looks much like the dead time of the
other kind; a chessboard and its complement, which are nearly all border, tell how much it is.

References:
    G. F. Knoll, "Radiation Detection and Measurement", chapter 4: both models, and the two-source method.
    Hamamatsu, "Photomultiplier Tubes", eq. 6-2.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.optimize import least_squares

from instrument.config import DeadTimeKind
from protocols import Floats, Mask

KINDS: Final[tuple[DeadTimeKind, ...]] = ("non-paralyzable", "paralyzable")

CERTAIN: Final = 16.0
"""Chi-square by which one model must be the better one to be told from the other: four standard deviations."""

_EDGE_SIGMA: Final = 0.05
"""Standard deviation of the prior of the edge loss, about 0."""

_START_S: Final = 2e-8

_LEAST_SCATTER: Final = 0.3
"""Standard deviation, over Poisson's, below which the scatter of counts is not taken to go."""


@dataclass(frozen=True, eq=False)
class LightLadder:
    """Count rates of pictures of known parts."""

    lit: Mask
    """``(pictures, parts)``: which parts, side by side across the field, a picture lights."""

    rate_hz: Floats
    """``(pictures,)`` counts a second."""

    sigma_hz: Floats
    """``(pictures,)`` standard deviation of each."""

    width_mirrors: Floats
    """``(parts,)`` width of each part: its light over its width is that of the line of mirrors at its border."""

    checker_hz: Floats
    """``(2,)`` counts a second of a chessboard and of its complement."""

    checker_sigma_hz: Floats
    """``(2,)`` standard deviation of both."""

    checker_sides: float
    """Sides of a lit mirror that border a dark one, in the mean over the chessboard: 4 over the mirrors a side of its cells."""

    @property
    def ends(self) -> Floats:
        """``(pictures, parts)``: how many of the two borders of a lit part have a dark part on their other side."""
        padded = np.pad(self.lit.astype(np.int64), ((0, 0), (1, 1)), mode="edge")
        before, after = padded[:, :-2], padded[:, 2:]
        return np.asarray(self.lit * (2 - before - after), np.float64)


@dataclass(frozen=True, eq=False)
class DeadTimeFit:
    """One model, fitted."""

    kind: DeadTimeKind
    """The model."""

    dead_time_s: float
    """Dead time."""

    sigma_s: float
    """Its standard deviation, made larger where the ladder scatters by more than its counts do."""

    chi_square: float
    """Of the residuals, in the units of the counts' own scatter."""

    degrees_of_freedom: int
    """Pictures less parameters."""

    light_hz: Floats
    """``(parts,)`` photons a second of each part."""

    stray_hz: float
    """Photons and dark counts a second of a black picture."""

    edge_loss: float
    """Share of a mirror's light that is lost at each of its sides that borders a dark mirror, as far as the ladder tells."""


def counted_hz(photons_hz: Floats, dead_time_s: float, kind: DeadTimeKind) -> Floats:
    """Counts a second of so many photons a second, of any shape."""
    if kind == "paralyzable":
        return photons_hz * np.exp(-photons_hz * dead_time_s)
    return photons_hz / (1 + photons_hz * dead_time_s)


def fit_dead_time(ladder: LightLadder, kind: DeadTimeKind) -> DeadTimeFit:
    """Fit one model to a ladder by least squares.

    Args:
        ladder: more pictures than parts and three.
        kind: the model.
    """
    parts = ladder.lit.shape[1]
    design = ladder.lit.astype(np.float64)
    borders = ladder.ends / ladder.width_mirrors
    scale_hz = float(ladder.rate_hz.max())

    measured = np.append(ladder.rate_hz, ladder.checker_hz)
    sigma = np.append(ladder.sigma_hz, ladder.checker_sigma_hz)

    def residuals(unknown: Floats) -> Floats:
        light, (dead, stray, edge, share) = unknown[:parts] * scale_hz, unknown[parts:]
        board = np.array([share, 1 - share]) * light.sum() * (1 - edge * ladder.checker_sides)
        photons = np.append((design - edge * borders) @ light, board) + stray * scale_hz
        predicted = counted_hz(photons, dead * _START_S, kind)
        return np.append((measured - predicted) / sigma, edge / _EDGE_SIGMA)

    first = np.linalg.lstsq(design, ladder.rate_hz / scale_hz, rcond=None)[0]
    start = np.concatenate([first, [1.0, 0.0, 0.0, 0.5]])
    fit = least_squares(residuals, start, method="lm", xtol=1e-12, ftol=1e-12)
    jacobian, found = np.asarray(fit.jac, np.float64), np.asarray(fit.x, np.float64)
    covariance = np.linalg.pinv(jacobian.T @ jacobian)
    chi_square, freedom = float(2 * fit.cost), len(measured) + 1 - len(start)
    wider = max(1.0, chi_square / max(freedom, 1)) ** 0.5
    return DeadTimeFit(
        kind=kind,
        dead_time_s=float(found[parts]) * _START_S,
        sigma_s=float(covariance[parts, parts]) ** 0.5 * _START_S * wider,
        chi_square=chi_square,
        degrees_of_freedom=freedom,
        light_hz=np.asarray(found[:parts] * scale_hz, np.float64),
        stray_hz=float(found[parts + 1]) * scale_hz,
        edge_loss=float(found[parts + 2]),
    )


def better(ladder: LightLadder) -> tuple[DeadTimeFit, float]:
    """Fit both models; give the one that fits better, and by how much chi-square the other one is worse.

    Where that is less than ``CERTAIN``, the difference between both dead times is in the standard deviation.

    Counts with dead time scatter by less than Poisson's: by the factor 1 - m tau at m counts a second, to first order for
    both kinds.
    """
    first_s = max(0.0, min(fit_dead_time(ladder, kind).dead_time_s for kind in KINDS))
    ladder = replace(
        ladder,
        sigma_hz=ladder.sigma_hz * np.clip(1 - ladder.rate_hz * first_s, _LEAST_SCATTER, 1),
        checker_sigma_hz=ladder.checker_sigma_hz * np.clip(1 - ladder.checker_hz * first_s, _LEAST_SCATTER, 1),
    )
    fits = sorted((fit_dead_time(ladder, kind) for kind in KINDS), key=lambda fit: fit.chi_square)
    best, other = fits
    between = other.chi_square - best.chi_square
    if between < CERTAIN:
        both_s = float(np.hypot(best.sigma_s, best.dead_time_s - other.dead_time_s))
        best = replace(best, sigma_s=both_s)
    return best, between
