"""The non-negative image of least total variation that explains the values within their noise."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Self

import numpy as np

from instrument.numerics.operators import Operator, Scaled, largest_eigenvalue
from instrument.numerics.tv_steps import CORNERS, K_SQUARED, dual_step, gradient_norms, primal_step
from protocols import Floats, Singles

EIGENVALUE_MARGIN: Final = 1.05
"""Factor on an eigenvalue that the power method found, which approaches the largest one from below."""

_SIGMA_K_SQUARED = 2.0  # sigma ||K||^2: a larger one cleans a dark ground sooner, a smaller one gains contrast sooner
_SIGMA = _SIGMA_K_SQUARED / K_SQUARED
_TAU = 1 / (0.5 + _SIGMA_K_SQUARED)  # so that 1 / tau - sigma ||K||^2 = 1/2
_RHO = 1.7  # over-relaxation, where its bound allows it: see ``relaxation_of``
_BELOW = 0.02  # distance kept from that bound
_CHECK_EVERY = 10  # iterations from one look at the tolerance to the next
_EDGE = 0.2  # gradient, in typical transmissions, at which reweighting halves the penalty
_NOISY = 0.1  # lambda, in typical transmissions, above which reweighting more than once invents edges
_LEAST_LAMBDA = 0.02  # of the brightest pixel of A'b: with a smaller lambda first-order methods converge too slowly
_EXPLAINED = 1.05  # misfit at which the values count as explained
_STALLED = 0.8  # ratio of successive misfits above which further Bregman steps would fit errors of the model
_SCALE_STEPS = 8  # of the power method, for the scale of an image: a tenth more or less does not matter
_BUDGET = 4  # times ``iterations``: all solutions together


@dataclass(frozen=True, eq=False)
class TvState:
    """The images that the solver ended at, one as a rule, and what a warm start from there needs."""

    images: tuple[Singles, ...]
    """``(height, width)`` each."""

    duals: tuple[Singles, ...]
    """``(2, 4, height, width)`` each: dual variable of the gradients as in ``tv_steps``, divided by ``eigenvalue``."""

    eigenvalue: float
    """Upper bound of the eigenvalues of A'A, A whitened."""

    misfit: float
    """Root mean square of the residual in units of the noise: about 1 where the image explains the values."""

    iterations: int
    """Iterations of all solutions, those before a warm start included."""

    relaxation: float = _RHO
    """Over-relaxation rho of the iteration."""

    penalty: float = 0.0
    """Jump that the penalty takes from an edge of the first image, over its typical transmission: how strong the noise is."""

    scales: tuple[float, ...] = (1.0,)
    """Factor on each image with which all are seen alike."""

    @classmethod
    def zero(cls, shapes: tuple[tuple[int, int], ...], eigenvalue: float) -> Self:
        """Give the start of a first solution: images, of ``shapes`` (height, width), and dual variables are 0."""
        images = tuple(np.zeros(shape, np.float32) for shape in shapes)
        duals = tuple(np.zeros((2, CORNERS, *shape), np.float32) for shape in shapes)
        return cls(images, duals, eigenvalue, misfit=float("nan"), iterations=0, scales=(1.0,) * len(shapes))

    @property
    def image(self) -> Singles:
        """``(height, width)``: the first image."""
        return self.images[0]

    @property
    def dual(self) -> Singles:
        """``(2, 4, height, width)``: dual variable of the first image."""
        return self.duals[0]


def total_variation(
    operator: Operator,
    values: Singles,
    *,
    strength: float = 3.0,
    finer: Sequence[int] | None = None,
    reweightings: int | None = None,
    bregman_steps: int = 0,
    tolerance: float = 0.005,
    iterations: int = 400,
    start: TvState | None = None,
) -> TvState:
    """Minimise 1/2 ||A x - b||^2 + lambda sum w |grad x| over x >= 0.

    x may be several images, as those of an object and of what stands still behind it. The sum is over the pixels of all, and no
    gradient reaches from one image to another.

    The rows must be whitened, so that each value has noise of variance 1. The norm of the gradient is isotropic and the mean
    over a pixel's four corners. lambda is ``strength`` times the standard deviation, rms over pixels, of A'n for white noise n
    of variance 1: for Hadamard rows of noise sigma sqrt(2) that is strength sqrt(rows / 2) / sigma.

    Total variation lowers contrast, which is restored in one of two ways. *Reweighting* ("freeing" the edges found) solves
    again with w = e / (|grad x| + e), e being 0.2 of the typical transmission, so that edges found are no longer penalised. A
    *Bregman step* adds the residual to the values and solves again. ``docs/decisions/0008-edge-reweighted-tv.md`` compares them.

    By default a cold start solves once with w = 1 and then reweights twice, or once where the noise is strong: where lambda
    (over the eigenvalue), the jump that the penalty takes from an edge, is above a tenth of the typical transmission. A warm
    start reweights once, after a solution with w = 1 only where the noise is strong.

    Where lambda would be so small that the iteration converged too slowly, a larger lambda is taken, and Bregman steps follow
    until the misfit is 1.05 or less, or a step lowers it by less than a fifth: what is then left is an error of the model, such
    as one of the motion, that no image explains.

    A solution ends when the predicted values change by less than ``tolerance`` (rms, in units of their noise; of half their
    misfit where Bregman steps are to follow because of a small lambda) in ten iterations. All solutions together take at most
    four times ``iterations``.

    Args:
        operator: A, whitened.
        values: ``(rows,)`` b, whitened.
        strength: larger values smooth more; 3 suits reweighting, 4 to 6 Bregman steps alone.
        finer: for each image, how many times smaller than usual its pixels are; None for 1. The total variation of the same
            object in n times smaller pixels is n times larger, and the noise of a pixel n^2 times smaller, by which it is
            weighted: with n times the strength it is smoothed alike.
        reweightings: number of reweighted solutions; None chooses it as described above, 0 gives plain total variation.
        bregman_steps: number of Bregman steps after those.
        tolerance: change of the predicted values at which a solution ends.
        iterations: largest number of iterations of one solution.
        start: result of an earlier call with similar rows.

    References:
        L. Condat, J. Optim. Theory Appl. 158 (2013) 460, algorithm 3.1; B. C. Vu, Adv. Comput. Math. 38 (2013) 667.
        E. J. Candes, M. B. Wakin, S. P. Boyd, J. Fourier Anal. Appl. 14 (2008) 877 (reweighting).
        S. Osher et al., Multiscale Model. Simul. 4 (2005) 460 (Bregman).
    """
    solver = _CondatVu(
        operator, values, strength=strength, finer=finer, tolerance=tolerance, iterations=iterations, start=start
    )
    if start is None or reweightings == 0 or (reweightings is None and solver.noisy):
        solver.solve(values, reweighted=False)
    if reweightings is None:
        reweightings = 2 if start is None and not solver.noisy else 1
    for _ in range(reweightings):
        solver.solve(values, reweighted=True)
    misfit = _take_bregman_steps(solver, values, bregman_steps, reweighted=reweightings > 0)
    return TvState(
        tuple(layer.image for layer in solver.layers),
        tuple(layer.dual for layer in solver.layers),
        solver.eigenvalue,
        misfit,
        solver.iterations_done,
        solver.relaxation,
        solver.penalty,
        solver.scales,
    )


def _take_bregman_steps(solver: "_CondatVu", values: Singles, steps: int, *, reweighted: bool) -> float:
    """Take ``steps`` Bregman steps, and more while a raised lambda leaves values unexplained. Return the last misfit."""
    target, residual = values, values - solver.predicted()
    misfit, previous = _rms(residual), np.inf
    while steps > 0 or (
        solver.lambda_raised and misfit > _EXPLAINED and misfit < _STALLED * previous and solver.budget > 0
    ):
        target = (target + residual).astype(np.float32)
        solver.solve(target, reweighted=reweighted)
        residual = values - solver.predicted()
        misfit, previous = _rms(residual), misfit
        steps -= 1
    return misfit


class _Layer:
    """One of the images, its dual variable, and what its steps need.

    Where images are seen with different weight, as one on a finer grid is, a step that suits one of them hardly moves the other.
    The solver therefore works on each image divided by its ``scale``, with which all are seen alike. The image itself stands
    here; the scale is in the sizes of the steps.
    """

    def __init__(self, image: Singles, dual: Singles, scale: float, scaled_lambda: float) -> None:
        self.image = image.copy()
        self.dual = dual.copy()
        self.scale = scale
        self.scaled_lambda = scaled_lambda
        self.bound = np.zeros((CORNERS, *image.shape), np.float32)

    @property
    def typical(self) -> float:
        """Typical transmission: the mean over the image, each pixel weighted by its own transmission."""
        total = float(self.image.sum())
        return float(np.vdot(self.image, self.image)) / total if total > 0 else 0.0

    def set_bound(self, *, reweighted: bool) -> None:
        """Set the largest length of each dual vector, ``(4, height, width)``: 2 lambda w / (4 L), as K is half a gradient."""
        self.bound[:] = 2 * self.scale * self.scaled_lambda / CORNERS
        edge = np.float32(_EDGE * self.typical)
        if reweighted and edge > 0:
            self.bound *= edge / (gradient_norms(self.image) + edge)
        np.maximum(self.bound, np.float32(1e-20), out=self.bound)


class _CondatVu:
    """Condat's algorithm 3.1 on the objective divided by the eigenvalue L of A'A, so that the data term has curvature 1.

    One iteration, with x the image and y the dual variable, is

        x~ = max(0, x - tau A'(A x - b) / L - tau K'y)
        y~ = projection of y + sigma K(2 x~ - x) on vectors no longer than lambda w / (2 L)
        (x, y) = rho (x~, y~) + (1 - rho) (x, y).

    The step sizes meet Condat's condition 1 / tau - sigma ||K||^2 >= 1/2 with equality. Convergence is proved for
    rho < 2 - mu / 2, mu being the largest eigenvalue of (1 / tau - sigma K'K)^-1 A'A / L: ``relaxation_of`` keeps below it. See
    "Step sizes" in ``docs/decisions/0008-edge-reweighted-tv.md``.
    """

    def __init__(
        self,
        operator: Operator,
        values: Singles,
        *,
        strength: float,
        finer: Sequence[int] | None,
        tolerance: float,
        iterations: int,
        start: TvState | None,
    ) -> None:
        if start is None:
            start = _cold_start(operator)
        self.operator = operator
        self.ends = np.cumsum([image.size for image in start.images])[:-1]
        self.eigenvalue, self.iterations_done, self.relaxation = start.eigenvalue, start.iterations, start.relaxation
        self.scales = start.scales
        scale = max(self.eigenvalue, 1e-30)
        least = [_LEAST_LAMBDA * float(part.max(initial=0.0)) / scale for part in self._split(operator.rmatvec(values))]
        noise = [_rms(part) / scale for part in self._split(operator.rmatvec(_white(operator.shape[0])))]
        wanted = [strength * times * each for times, each in zip(finer or [1] * len(noise), noise, strict=True)]
        self.lambda_raised = wanted[0] < least[0]
        self.layers = [
            _Layer(image, dual, own, max(of, at_least))
            for image, dual, own, of, at_least in zip(
                start.images, start.duals, start.scales, wanted, least, strict=True
            )
        ]
        self.tolerance, self.iterations = tolerance, iterations
        self.budget = _BUDGET * iterations

    @property
    def noisy(self) -> bool:
        """Whether the penalty takes more than a tenth of the typical transmission from an edge of the first image."""
        return self.penalty > _NOISY

    @property
    def penalty(self) -> float:
        """Jump that the penalty takes from an edge of the first image, over its typical transmission."""
        return self.layers[0].scaled_lambda / max(self.layers[0].typical, 1e-30)

    def _split(self, pixels: Singles) -> list[Singles]:
        """Give the pixels of each image."""
        return np.split(pixels, self.ends)

    def predicted(self) -> Singles:
        """Give the values A x of the current images, ``(rows,)``."""
        return self.operator.matvec(np.concatenate([layer.image.ravel() for layer in self.layers]))

    def solve(self, values: Singles, *, reweighted: bool) -> None:
        """Iterate from where the last solution ended."""
        tau_data = _TAU / max(self.eigenvalue, 1e-30)
        for layer in self.layers:
            layer.set_bound(reweighted=reweighted)
        # A x - b follows the relaxed images without a product of its own, as it is linear in x.
        residual = self.predicted() - values
        checked = residual.copy()
        most, iteration = min(self.iterations, self.budget), 0
        for iteration in range(1, most + 1):
            proposal = self.operator.rmatvec(residual)  # the gradient, until the steps replace it
            parts = [
                part.reshape(layer.image.shape) for layer, part in zip(self.layers, self._split(proposal), strict=True)
            ]
            for layer, part in zip(self.layers, parts, strict=True):
                primal_step(layer.image, layer.dual, part, tau_data * layer.scale**2, _TAU * layer.scale)
            residual += np.float32(self.relaxation) * (self.operator.matvec(proposal) - values - residual)
            for layer, part in zip(self.layers, parts, strict=True):
                dual_step(layer.image, layer.dual, part, layer.bound, _SIGMA / layer.scale, self.relaxation)
            if iteration % _CHECK_EVERY == 0 or iteration == most:
                if _rms(residual - checked) < self._tolerated_change(residual):
                    break
                checked[:] = residual
        self.iterations_done += iteration
        self.budget -= iteration
        for layer in self.layers:
            np.maximum(layer.image, 0, out=layer.image)

    def _tolerated_change(self, residual: Singles) -> float:
        """Give the change of the predicted values (rms) below which a solution ends."""
        return self.tolerance * (max(1.0, _rms(residual) / 2) if self.lambda_raised else 1.0)


def relaxation_of(operator: Operator, eigenvalue: float) -> float:
    """Choose the over-relaxation rho of the iteration for these rows: 1.7, or less where convergence would not be proved.

    The bound is 2 - mu / 2 (see ``_CondatVu``). mu is the largest Rayleigh quotient of three images for which K'K is known: an
    even one, stripes, and a checkerboard, for which 1 / tau - sigma K'K is smallest. Smooth patterns hardly see a checkerboard,
    and the bound is about 1.8; all patterns of an object at rest see every image alike, and it is about 1.05.

    Args:
        operator: A, whitened.
        eigenvalue: upper bound of the eigenvalues of A'A.
    """
    rows, columns = (
        np.concatenate([np.indices(shape)[axis].ravel() for shape in operator.image_shapes]) for axis in range(2)
    )
    probes = ((np.zeros_like(rows), 0.0), (columns, 0.5), (rows, 0.5), (rows + columns, 1.0))
    mu = 0.0
    for parity, share in probes:
        image = (1 - 2 * (parity % 2)).astype(np.float32)
        seen = operator.matvec(image)
        metric = 1 / _TAU - share * _SIGMA_K_SQUARED
        mu = max(mu, float(np.vdot(seen, seen)) / (max(eigenvalue, 1e-30) * image.size * metric))
    return float(min(_RHO, max(1.0, 2 - mu / 2 - _BELOW)))


def _cold_start(operator: Operator) -> TvState:
    """Give images of 0, with scales, eigenvalue and relaxation of the rows."""
    shapes = operator.image_shapes
    scales = (1.0,) if len(shapes) == 1 else _scales(operator)
    scaled = operator if len(shapes) == 1 else Scaled(operator, _spread(shapes, scales))
    eigenvalue = largest_eigenvalue(scaled) * EIGENVALUE_MARGIN
    start = TvState.zero(shapes, eigenvalue)
    return replace(start, scales=scales, relaxation=relaxation_of(scaled, eigenvalue))


def _scales(operator: Operator) -> tuple[float, ...]:
    """Give factors on the images with which the largest eigenvalue of A'A is the same for each of them alone."""
    shapes = operator.image_shapes
    alone = [
        largest_eigenvalue(Scaled(operator, _spread(shapes, np.eye(len(shapes))[k])), _SCALE_STEPS)
        for k in range(len(shapes))
    ]
    return tuple(float(np.sqrt(max(alone) / max(value, 1e-30))) for value in alone)


def _spread(shapes: tuple[tuple[int, int], ...], factors: Sequence[float] | Floats) -> Singles:
    """``(pixels,)``: the factor of each image at each of its pixels."""
    return np.concatenate(
        [np.full(height * width, factor, np.float32) for (height, width), factor in zip(shapes, factors, strict=True)]
    )


def _white(rows: int) -> Singles:
    """Draw white noise n of variance 1, always the same: the rms of A'n is the noise of a pixel that is projected back."""
    return np.random.default_rng(0).standard_normal(rows).astype(np.float32)


def _rms(values: Singles | Floats) -> float:
    """Give the root mean square."""
    return float(np.sqrt(np.mean(np.square(values)))) if values.size else 0.0
