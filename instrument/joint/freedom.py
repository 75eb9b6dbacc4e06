"""How many unknowns an image takes from the values, so that what it leaves unexplained can be held against the noise.

An image of p free numbers explains as much of the noise of n values as of anything else: what it leaves is smaller than the noise
by sqrt(1 - p / n) although all is well. Total variation has no p of its own: it frees as many numbers as the object has edges.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from instrument.joint.detail import Picture
from instrument.numerics import total_variation

_PROBE: Final = 0.3
"""Size of the probe, in units of the noise: small beside what makes other edges, large beside what the solver leaves open."""

_ITERATIONS: Final = (20, 60)
"""Of the solver, which begins at the image: fewest and most; the more the fewer values there are,"""

_PRODUCTS: Final = 20_000
"""so that values times iterations make this number: where values are few, unknowns are a larger share of them."""

_LEAST_LEFT: Final = 0.25
"""Share of the values that is taken to be left over in any case."""


@dataclass(frozen=True)
class Freedom:
    """What an image leaves unexplained, and how many values it had for that."""

    unknowns: float
    """Effective number of unknowns of the image, its degrees of freedom."""

    misfit: float
    """Root mean square of what is left, over the noise, per value that is left over: about 1 where path and image are right."""


def freedom_of(picture: Picture) -> Freedom:
    """Estimate the degrees of freedom of an image, and what it leaves unexplained for each of the values that are left over.

    The degrees of freedom are the divergence of the predicted values by the measured ones. It is found by one probe: values
    with a random sign each, of a fraction of the noise, are added, and the prediction follows them by as much as there are
    degrees of freedom, as p = <z, A x(b + e z) - A x(b)> / e in the mean over signs z. One probe is right to sqrt(2 p).

    Args:
        picture: path, and the image along it.

    References:
        C. M. Stein, Annals of Statistics 9 (1981) 1135: divergence as degrees of freedom.
        S. Ramani, T. Blu, M. Unser, IEEE Trans. Image Process. 17 (2008) 1540: one probe for any denoiser.
    """
    problem, state = picture.iterate.problem, picture.state
    rows, values = problem.rows()
    count = len(problem.values)
    if not (count and np.isfinite(state.misfit)):
        return Freedom(0.0, state.misfit)
    signs = np.zeros(len(values), np.float32)  # those of an object that passes by have more rows, which are not counted
    signs[:count] = np.where(np.random.default_rng(0).random(count) < 0.5, -1, 1)
    probed = total_variation(
        rows,
        (values + _PROBE * signs).astype(np.float32),
        strength=picture.strength,
        finer=problem.finer,
        reweightings=1,
        tolerance=0.03,
        iterations=int(np.clip(_PRODUCTS // count, *_ITERATIONS)),
        start=state,
    )
    pixels = np.concatenate([(new - old).ravel() for new, old in zip(probed.images, state.images, strict=True)])
    followed = float(np.vdot(signs, rows.matvec(pixels))) / _PROBE
    unknowns = float(np.clip(followed, 0.0, count))
    left = max(1 - unknowns / count, _LEAST_LEFT)
    return Freedom(unknowns, state.misfit / left**0.5)
