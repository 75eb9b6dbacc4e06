"""What is done for an object whose detail is as fine as a pixel: less smoothing, and a path that fits it.

The usual smoothing takes the contrast of such detail, and values that depend on it stay unexplained. The path suffers with the
image. What an image lacks looks like motion, so that the path shakes by fractions of a pixel; the image that is solved for along
a shaken path is blurred by it, and agrees with it. From there no small step leads out. A plain path, without the shaking, does.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.polynomial import chebyshev

from instrument.joint.iterate import Iterate
from instrument.joint.rounds import FEWEST_FRAMES, USUAL, refined
from instrument.numerics import TvState
from instrument.reconstruction import solved
from instrument.tracking import Trajectory

_EXPLAINED: Final = 1.07
"""Misfit up to which an image explains what was measured: objects without fine detail leave 0.93 to 1.03 at any noise."""

_BETTER: Final = 0.12
"""Relative fall of the squared misfit from which on half the smoothing is believed. Without fine detail half of it takes up to
0.08, of the noise; bars as fine as a pixel, 0.2 and more."""

_PLAIN_DEGREE: Final = 5
"""Degree of the polynomial that a plain path is."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A path, and the image along it."""

    iterate: Iterate
    """The path, and the problem with the image's grid."""

    state: TvState
    """The image, as the solver left it."""

    strength: float
    """Strength of the smoothing."""

    @classmethod
    def of(cls, iterate: Iterate, strength: float = USUAL) -> "Picture":
        """Solve for the image without a warm start, as what earlier images invented with a worse path would persist."""
        return cls(iterate, solved(iterate.problem, strength=strength), strength)

    def explains_more_than(self, other: "Picture") -> bool:
        """Whether it leaves so much less unexplained that it is believed although it is smoothed less."""
        return self.state.misfit**2 < (1 - _BETTER) * other.state.misfit**2


def in_detail(usual: Picture, *, fitted: bool) -> Picture:
    """Give path and image with the detail that the usual smoothing leaves unexplained; the usual ones where there is none.

    Half the smoothing is tried, along the path found and along a plain one. Where that explains far more, path and light are
    refined further by such images, with a quarter of the smoothing where much stays unexplained even so. Where path or light are
    in error but the object has no such detail, less smoothing does not help, and nothing is changed.

    Args:
        usual: path, and image with the usual smoothing.
        fitted: whether the light model is fitted to the run.
    """
    iterate = usual.iterate
    if usual.state.misfit < _EXPLAINED or len(iterate.problem.values) < FEWEST_FRAMES:
        return usual
    half = usual.strength / 2
    tried = [Picture.of(start, half) for start in (iterate, iterate.along(_plain(iterate.trajectory)))]
    best = min(tried, key=lambda picture: picture.state.misfit)
    if not best.explains_more_than(usual):
        return usual
    strength = half if best.state.misfit < _EXPLAINED else half / 2
    refinement = refined(best.iterate, None, fitted=fitted, strength=strength)
    last = Picture.of(refinement.iterate, strength)
    better = last.state.misfit < best.state.misfit if strength == half else last.explains_more_than(best)
    return last if better else best


def _plain(trajectory: Trajectory) -> Trajectory:
    """Give the polynomial next to a path."""
    place = np.linspace(-1, 1, len(trajectory))
    fits = chebyshev.chebfit(place, trajectory.displacement_px, _PLAIN_DEGREE)
    plain_px = chebyshev.chebval(place, fits).T
    return replace(trajectory, displacement_px=np.asarray(plain_px - plain_px[trajectory.reference_frame], np.float64))
