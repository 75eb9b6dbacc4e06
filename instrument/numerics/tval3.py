r"""TVAL3's model and method, for comparison: total variation by an augmented Lagrangian with alternating directions.

With D the gradient, w its copy in each pixel and nu the multiplier of D u = w, it minimises

    sum ||w|| - nu'(D u - w) + beta/2 ||D u - w||^2 + mu/2 ||A u - b||^2

over u >= 0, in turn over w (exactly: shrinkage) and over u (one step down the gradient), then updates the multiplier. This is
the model TV + mu/2 ||A u - b||^2, for noisy values.

References:
    C. Li, W. Yin, H. Jiang, Y. Zhang, "An efficient augmented Lagrangian method with applications to total variation
    minimization", Comput. Optim. Appl. 56 (2013) 507-530.
    J. Barzilai, J. M. Borwein, IMA J. Numer. Anal. 8 (1988) 141, equation 6 (length of the step).
    H. Zhang, W. W. Hager, SIAM J. Optim. 14 (2004) 1043 (line search that lets the objective rise now and then).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from instrument.numerics.operators import Operator, largest_eigenvalue
from protocols import Floats, Singles

_ABOVE = 1.02  # the power method approaches the largest eigenvalue from below
_RANGE = (0.5, 1.5)  # of the scaled values, largest less smallest
_ARMIJO = 1e-5
_SHORTER = 0.6
_TRIALS = 5
_MEMORY = 0.9995  # weight of earlier objectives in the line search
_INNER_TOLERANCE = 1e-3  # relative change of the image in one step at which the multiplier is updated
_INNER_ITERATIONS = 10  # steps at most between updates of the multiplier


@dataclass(frozen=True, eq=False)
class AlState:
    """Where the solver ended."""

    image: Singles
    """``(height, width)``."""

    misfit: float
    """Root mean square of the residual A x - b, in the units of b."""

    iterations: int
    """Steps of the image: one product with A and one with its transpose each, and one with A for each shortened step."""

    weight: float
    """lambda of the same model in data units: 1/2 ||A x - b||^2 + lambda TV(x)."""


@dataclass(frozen=True, eq=False)
class _Scaled:
    """A with norm 1, and b of a range near 1."""

    operator: Operator
    norm: float
    values: Floats
    stretch: float

    @classmethod
    def of(cls, operator: Operator, values: Singles) -> "_Scaled":
        norm = max(float(np.sqrt(largest_eigenvalue(operator) * _ABOVE)), 1e-30)
        scaled = values.astype(np.float64) / norm
        spread = float(np.ptp(scaled)) if scaled.size else 0.0
        stretch = float(np.clip(spread, *_RANGE)) / spread if spread > 0 else 1.0
        return cls(operator, norm, scaled * stretch, stretch)

    def forward(self, image: Floats) -> Floats:
        return self.operator.matvec(image.astype(np.float32).ravel()).astype(np.float64) / self.norm

    def back(self, values: Floats) -> Floats:
        image = self.operator.rmatvec(values.astype(np.float32)).reshape(self.operator.image_shape)
        return image.astype(np.float64) / self.norm


def tv_augmented_lagrangian(
    operator: Operator,
    values: Singles,
    *,
    mu: float = 2.0**8,
    beta: float = 2.0**5,
    tolerance: float = 1e-6,
    iterations: int = 1025,
    watch: Callable[[Floats], object] | None = None,
) -> AlState:
    """Minimise TV(x) + mu/2 ||A x - b||^2 of the scaled A and b, isotropic, with periodic differences.

    A is divided by its largest singular value; b by the same, and then stretched until its range is between 0.5 and 1.5:
    ``mu`` and ``beta`` are of that problem, not in data units. Defaults are those of the published program.

    Args:
        operator: A.
        values: ``(rows,)`` b.
        mu: weight of the values. Powers of 2 from 2^4 (noisy) to 2^13.
        beta: weight of D u = w.
        tolerance: relative change of the image from one update of the multiplier to the next at which it ends.
        iterations: steps of the image at most, in all.
        watch: called with each image, on the scale of the data.
    """
    scaled = _Scaled.of(operator, values)
    search = _Search(scaled, mu, beta)
    spent = 0
    while spent < iterations:
        before = search.image
        search.begin()
        for _ in range(min(_INNER_ITERATIONS, iterations - spent)):
            last = search.image
            search.step()
            spent += 1
            if watch is not None:
                watch(search.image / scaled.stretch)
            if _change(search.image, last) < _INNER_TOLERANCE:
                break
        search.update_multiplier()
        if _change(search.image, before) < tolerance:
            break
    image: Singles = (search.image / scaled.stretch).astype(np.float32)
    residual = operator.matvec(image.ravel()) - values
    misfit = float(np.sqrt(np.mean(np.square(residual)))) if residual.size else 0.0
    return AlState(image, misfit, spent, weight=scaled.norm**2 / (mu * scaled.stretch))


class _Search:
    """The image with all that goes with it, and the steps that lower the augmented Lagrangian."""

    def __init__(self, scaled: _Scaled, mu: float, beta: float) -> None:
        self.scaled, self.mu, self.beta = scaled, mu, beta
        self.image: Floats = np.maximum(scaled.back(scaled.values), 0)
        self.seen: Floats = scaled.forward(self.image)
        self.slope: Floats = _gradient(self.image)
        self.nu: Floats = np.zeros_like(self.slope)
        self.copy: Floats = self.slope
        self.length = 1 / (mu + 8 * beta)  # 8: the largest eigenvalue of D'D

    def begin(self) -> None:
        """Begin with a new multiplier: w follows, and the line search forgets what was."""
        self.copy = _shrink(self.slope - self.nu / self.beta, 1 / self.beta)
        self.allowed, self.averaged = self._objective(self.slope, self.seen), 1.0

    def step(self) -> None:
        """Take one step of u down the gradient; then w."""
        down = self._down()
        length = self.length
        image, seen, slope = self._moved(length, down)
        for trial in range(1, _TRIALS + 1):
            enough = self.allowed + _ARMIJO * float(np.vdot(down, image - self.image))
            if self._objective(slope, seen) <= enough:
                break
            length = length * _SHORTER if trial < _TRIALS else 1 / (self.mu + 8 * self.beta)  # which always lowers it
            image, seen, slope = self._moved(length, down)
        move = image - self.image
        bend = self.beta * _power(slope - self.slope) + self.mu * _power(seen - self.seen)
        if bend > 0:
            self.length = _power(move) / bend
        self.image, self.seen, self.slope = image, seen, slope
        self.copy = _shrink(slope - self.nu / self.beta, 1 / self.beta)
        objective = self._objective(slope, seen)
        averaged = _MEMORY * self.averaged + 1  # Q of Zhang and Hager
        self.allowed = (_MEMORY * self.averaged * self.allowed + objective) / averaged
        self.averaged = averaged

    def update_multiplier(self) -> None:
        """Add what still separates D u from w."""
        self.nu = self.nu - self.beta * (self.slope - self.copy)

    def _moved(self, length: float, down: Floats) -> tuple[Floats, Floats, Floats]:
        """Give the image after a step of this length, its values and its gradient."""
        image: Floats = np.maximum(self.image - length * down, 0)
        return image, self.scaled.forward(image), _gradient(image)

    def _down(self) -> Floats:
        """Give the gradient of the augmented Lagrangian by u."""
        misfit_gradient = self.scaled.back(self.mu * (self.seen - self.scaled.values))
        return misfit_gradient + _adjoint(self.beta * (self.slope - self.copy) - self.nu)

    def _objective(self, slope: Floats, seen: Floats) -> float:
        """Value of the augmented Lagrangian at an image with this gradient and these values."""
        apart, residual = slope - self.copy, seen - self.scaled.values
        total = float(np.sqrt(self.copy[0] ** 2 + self.copy[1] ** 2).sum())
        total += self.beta / 2 * _power(apart) - float(np.vdot(self.nu, apart))
        return total + self.mu / 2 * _power(residual)


def _gradient(image: Floats) -> Floats:
    """Forward differences down and across, periodic."""
    return np.stack([np.roll(image, -1, 0) - image, np.roll(image, -1, 1) - image])


def _adjoint(slope: Floats) -> Floats:
    """Transpose of ``_gradient``."""
    image: Floats = np.roll(slope[0], 1, 0) - slope[0] + np.roll(slope[1], 1, 1) - slope[1]
    return image


def _shrink(slope: Floats, by: float) -> Floats:
    """Shorten each pixel's vector by ``by``, at most to 0."""
    length = np.sqrt(slope[0] ** 2 + slope[1] ** 2)
    kept: Floats = slope * (np.maximum(length - by, 0) / np.maximum(length, 1e-300))
    return kept


def _power(values: Floats) -> float:
    return float(np.vdot(values, values))


def _change(image: Floats, before: Floats) -> float:
    return float(np.linalg.norm(image - before) / max(float(np.linalg.norm(before)), 1e-30))
