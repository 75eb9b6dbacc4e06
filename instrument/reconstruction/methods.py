"""The methods that make an image, each a solver under a name, all with the same contract."""

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from scipy.sparse.linalg import LinearOperator, lsqr

from instrument.choices import Method
from instrument.numerics import TvState, total_variation, tv_augmented_lagrangian
from instrument.reconstruction.conventional import inverse_hadamard
from instrument.reconstruction.dgi import ghost_image
from instrument.reconstruction.problem import Problem
from instrument.reconstruction.region import Region
from instrument.reconstruction.shifted_hadamard import ShiftedHadamard
from instrument.reconstruction.solved import solved
from protocols import Floats, InputError, Singles

_MOST_STEPS: Final = 500
"""Steps of conjugate gradients at most."""


@dataclass(frozen=True, eq=False)
class Solution:
    """The image that a solver found."""

    image: Floats | Singles
    """``(height, width)`` pixels of ``region``, in units of the values for one pixel and one pattern."""

    region: Region
    """Pixels of the field that ``image`` covers."""

    misfit: float = float("nan")
    """Root mean square of what the image leaves unexplained, over the noise; NaN where the solver does not compute it."""

    iterations: int = 0
    """Number of iterations of the solver; 0 where it has none."""

    still: Floats | Singles | None = None
    """``(size, size)``: image of what stands still, in the same units; None where it was not asked for."""


class Solver(Protocol):
    """Finds the image of a problem."""

    def __call__(self, problem: Problem, strength: float) -> Solution:
        """Solve with this strength of smoothing, which a solver that does not smooth ignores."""
        ...


@dataclass(frozen=True)
class ImageMethod:
    """A method to make an image."""

    summary: str
    """One line that describes it to people."""

    solve: Solver
    """Solver that makes the image."""

    finer: bool = False
    """Whether its image may have smaller pixels than the patterns."""

    strength: float | None = None
    """Usual strength of the smoothing in units of the noise; None where the method has none."""


def solution_of(problem: Problem, state: TvState) -> Solution:
    """Give what total variation found as a solution."""
    still = state.images[1] if problem.still else None
    return Solution(state.image, problem.region, state.misfit, state.iterations, still)


def _tv(problem: Problem, strength: float) -> Solution:
    return solution_of(problem, solved(problem, strength=strength))


def _tv_fourier(problem: Problem, strength: float) -> Solution:
    return solution_of(problem, total_variation(*problem.with_fourier(), strength=strength, finer=problem.finer))


def _tv_bregman(problem: Problem, strength: float) -> Solution:
    state = solved(problem, strength=strength, reweightings=0, bregman_steps=1)
    return solution_of(problem, state)


def _tv_al(problem: Problem, strength: float) -> Solution:
    del strength  # TVAL3 weights the values against the largest eigenvalue and not against the noise
    rows, values = problem.hadamard()
    state = tv_augmented_lagrangian(rows, values)
    return Solution(state.image, problem.region, state.misfit, state.iterations)


def _pseudo_inverse(problem: Problem, strength: float) -> Solution:
    """Find the least image of least squares, by conjugate gradients that end where what is left is as large as the noise.

    The pseudo-inverse itself would amplify the noise of rows that are nearly alike beyond all measure.
    """
    del strength
    rows, values = problem.hadamard()
    operator = LinearOperator(
        rows.shape,
        matvec=lambda image: rows.matvec(image.astype(np.float32).ravel()),
        rmatvec=lambda left: rows.rmatvec(left.astype(np.float32).ravel()),
        dtype=np.float32,
    )
    noise = float(np.sqrt(len(values))) / max(float(np.linalg.norm(values)), 1e-30)
    found = lsqr(operator, values, atol=0.0, btol=noise, conlim=0.0, iter_lim=_MOST_STEPS)
    misfit = float(found[3]) / float(np.sqrt(len(values)))
    return Solution(
        np.asarray(found[0], np.float64).reshape(rows.image_shapes[0]), problem.region, misfit, int(found[2])
    )


def _dgi(problem: Problem, strength: float) -> Solution:
    """Sum the differential ghost images of H+ and of H-, with the gain that explains the differences best."""
    del strength
    pairs, size, area = problem.values.pairs, problem.values.size, problem.region
    image = np.zeros(area.shape)
    lit = np.where((pairs == 0).all(axis=1), size**2, size**2 / 2)
    for sign, counted, place_px, pattern_sum in (
        (1.0, problem.values.positive, problem.places.positive, lit),
        (-1.0, problem.values.negative, problem.places.negative, size**2 - lit),
    ):
        terms = np.stack([np.zeros_like(pairs), pairs])  # (1 + H) / 2, (1 - H) / 2
        patterns = ShiftedHadamard.of([0.5, 0.5 * sign], terms, np.stack([place_px] * 2), problem.field, area)
        image += ghost_image(patterns, counted.astype(np.float32), pattern_sum.astype(np.float32))
    rows, values = problem.hadamard()
    explained = rows.matvec(image.astype(np.float32).ravel())
    power = float(np.vdot(explained, explained))
    return Solution(image * (float(np.vdot(explained, values)) / power if power > 0 else 0.0), area)


def _conventional(problem: Problem, strength: float) -> Solution:
    del strength
    values = problem.values
    image = inverse_hadamard(values.difference, values.pairs, values.size)
    return Solution(image, Region.whole(values.size))


METHODS: Final[dict[Method, ImageMethod]] = {
    "tv": ImageMethod("least total variation, edges found freed", _tv, finer=True, strength=3.0),
    "tv-fourier": ImageMethod("the same, of the Fourier values' dithering too", _tv_fourier, finer=True, strength=3.0),
    "tv-bregman": ImageMethod(
        "least total variation, with a Bregman step instead of edges freed", _tv_bregman, finer=True, strength=5.0
    ),
    "tv-al": ImageMethod("TVAL3's model with its default weights", _tv_al),
    "pseudo-inverse": ImageMethod("least squares, as far as the noise allows", _pseudo_inverse),
    "dgi": ImageMethod("differential ghost imaging", _dgi),
    "conventional": ImageMethod("the inverse Hadamard transform, which ignores the motion", _conventional),
}
"""Every method by its name."""


def method_of(name: str) -> ImageMethod:
    """Give the method of that name.

    Raises:
        InputError: there is none.
    """
    for known, method in METHODS.items():
        if known == name:
            return method
    raise InputError(
        saw=f"the image method {name!r}", expected=f"one of {', '.join(METHODS)}", remedy="correct the name"
    )
