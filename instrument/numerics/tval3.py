r"""The model and the method of TVAL3, for comparison: total variation by an augmented Lagrangian with alternating directions.

With D the gradient, w its copy in each pixel and nu the multiplier of D u = w, it minimises

    sum ||w|| - nu'(D u - w) + beta/2 ||D u - w||^2 + mu/2 ||A u - b||^2

over u >= 0, in turn over w (exactly, by shrinkage) and over u (by one step along the negative gradient), and then updates the
multiplier. This is the model TV + mu/2 ||A u - b||^2, for noisy values.

References:
    C. Li, W. Yin, H. Jiang, Y. Zhang, "An efficient augmented Lagrangian method with applications to total variation
    minimization", Comput. Optim. Appl. 56 (2013) 507-530.
    J. Barzilai, J. M. Borwein, IMA J. Numer. Anal. 8 (1988) 141, equation 6 (step size).
    H. Zhang, W. W. Hager, SIAM J. Optim. 14 (2004) 1043 (line search that allows the objective to rise occasionally).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from instrument.numerics.operators import Operator, largest_eigenvalue
from protocols import Floats, Singles

_EIGENVALUE_MARGIN = 1.02  # the power method approaches the largest eigenvalue from below
_RANGE = (0.5, 1.5)  # bounds of the scaled values' range, largest minus smallest
_BETA = 2.0**5  # weight of D u = w, as in the published program
_ARMIJO = 1e-5  # share of the predicted decrease that a step must reach
_BACKTRACK = 0.6  # factor by which a step that does not is shortened
_TRIALS = 5  # step sizes tried in one step
_ETA = 0.9995  # weight of earlier objectives in the line search (Zhang and Hager)
_INNER_TOLERANCE = 1e-3  # relative change of the image in one step below which the multiplier is updated
_INNER_ITERATIONS = 10  # largest number of steps between updates of the multiplier


@dataclass(frozen=True, eq=False)
class AlState:
    """The image that the solver ended at."""

    image: Singles
    """``(height, width)``."""

    misfit: float
    """Root mean square of the residual A x - b, in the units of b."""

    iterations: int
    """Steps of the image. Each takes one product with A and one with A', and one more with A for each time it is shortened."""

    weight: float
    """lambda of the same model in the units of the data: 1/2 ||A x - b||^2 + lambda TV(x)."""


@dataclass(frozen=True, eq=False)
class _Scaled:
    """The problem scaled so that A has norm 1 and the range of b is near 1."""

    operator: Operator
    """A as given."""

    norm: float
    """Largest singular value of A, by which A and b are divided."""

    values: Floats
    """``(rows,)``: scaled b."""

    stretch: float
    """Factor by which b, and with it the image, is multiplied besides."""

    @classmethod
    def of(cls, operator: Operator, values: Singles) -> "_Scaled":
        """Scale a problem."""
        norm = max(float(np.sqrt(largest_eigenvalue(operator) * _EIGENVALUE_MARGIN)), 1e-30)
        scaled = values.astype(np.float64) / norm
        spread = float(np.ptp(scaled)) if scaled.size else 0.0
        stretch = float(np.clip(spread, *_RANGE)) / spread if spread > 0 else 1.0
        return cls(operator, norm, scaled * stretch, stretch)

    def forward(self, image: Floats) -> Floats:
        """Apply the scaled A: ``(height, width)`` to ``(rows,)``."""
        return self.operator.matvec(image.astype(np.float32).ravel()).astype(np.float64) / self.norm

    def back(self, values: Floats) -> Floats:
        """Apply its transpose: ``(rows,)`` to ``(height, width)``."""
        image = self.operator.rmatvec(values.astype(np.float32)).reshape(self.operator.image_shapes[0])
        return image.astype(np.float64) / self.norm


def tv_augmented_lagrangian(
    operator: Operator,
    values: Singles,
    *,
    mu: float = 2.0**8,
    tolerance: float = 1e-6,
    iterations: int = 1025,
    watch: Callable[[Floats], object] | None = None,
) -> AlState:
    """Minimise TV(x) + mu/2 ||A x - b||^2 of the scaled A and b, isotropic, with periodic differences.

    A and b are divided by the largest singular value of A, and b is then stretched until its range is between 0.5 and 1.5.
    ``mu`` refers to that problem, not to the units of the data. The defaults are those of the published program.

    Args:
        operator: A.
        values: ``(rows,)`` b.
        mu: weight of the values: powers of 2 from 2^4 (noisy values) to 2^13.
        tolerance: relative change of the image between two updates of the multiplier below which the solver ends.
        iterations: largest number of steps of the image.
        watch: function that is called with each image, ``(height, width)``, on the scale of the data.
    """
    scaled = _Scaled.of(operator, values)
    search = _Search(scaled, mu)
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
    """The image u, what depends on it, and the steps that lower the augmented Lagrangian."""

    def __init__(self, scaled: _Scaled, mu: float) -> None:
        self.scaled, self.mu, self.beta = scaled, mu, _BETA
        self.image: Floats = np.maximum(scaled.back(scaled.values), 0)
        self.predicted: Floats = scaled.forward(self.image)  # A u
        self.gradient: Floats = _gradient(self.image)  # D u
        self.nu: Floats = np.zeros_like(self.gradient)
        self.w: Floats = self.gradient
        self.step_size = self._safe_step_size()

    def begin(self) -> None:
        """Begin with a new multiplier: update w, and restart the line search."""
        self._shrink_w()
        self.reference, self.q = self._objective(self.gradient, self.predicted), 1.0

    def step(self) -> None:
        """Take one step of u along the negative gradient of the objective; then update w."""
        descent = self._objective_gradient()
        step_size = self.step_size
        image, predicted, gradient = self._moved(step_size, descent)
        for trial in range(1, _TRIALS + 1):
            enough = self.reference + _ARMIJO * float(np.vdot(descent, image - self.image))
            if self._objective(gradient, predicted) <= enough:
                break
            step_size = step_size * _BACKTRACK if trial < _TRIALS else self._safe_step_size()
            image, predicted, gradient = self._moved(step_size, descent)
        self._choose_next_step_size(image, predicted, gradient)
        self.image, self.predicted, self.gradient = image, predicted, gradient
        self._shrink_w()
        objective = self._objective(gradient, predicted)
        q = _ETA * self.q + 1
        self.reference = (_ETA * self.q * self.reference + objective) / q
        self.q = q

    def update_multiplier(self) -> None:
        """Add what still separates D u from w."""
        self.nu = self.nu - self.beta * (self.gradient - self.w)

    def _shrink_w(self) -> None:
        """Minimise over w."""
        self.w = _shrink(self.gradient - self.nu / self.beta, 1 / self.beta)

    def _safe_step_size(self) -> float:
        """Give the step size that always lowers the objective; 8 is the largest eigenvalue of D'D."""
        return 1 / (self.mu + 8 * self.beta)

    def _choose_next_step_size(self, image: Floats, predicted: Floats, gradient: Floats) -> None:
        """Set the step size of Barzilai and Borwein from the step to this image."""
        curvature = self.beta * _power(gradient - self.gradient) + self.mu * _power(predicted - self.predicted)
        if curvature > 0:
            self.step_size = _power(image - self.image) / curvature

    def _moved(self, step_size: float, descent: Floats) -> tuple[Floats, Floats, Floats]:
        """Give the image after a step of this size, its values A u and its gradient D u."""
        image: Floats = np.maximum(self.image - step_size * descent, 0)
        return image, self.scaled.forward(image), _gradient(image)

    def _objective_gradient(self) -> Floats:
        """Give the gradient of the augmented Lagrangian with respect to u."""
        data_term = self.scaled.back(self.mu * (self.predicted - self.scaled.values))
        return data_term + _adjoint(self.beta * (self.gradient - self.w) - self.nu)

    def _objective(self, gradient: Floats, predicted: Floats) -> float:
        """Give the augmented Lagrangian of an image with this gradient D u and these values A u."""
        split, residual = gradient - self.w, predicted - self.scaled.values
        total = float(np.sqrt(self.w[0] ** 2 + self.w[1] ** 2).sum())
        total += self.beta / 2 * _power(split) - float(np.vdot(self.nu, split))
        return total + self.mu / 2 * _power(residual)


def _gradient(image: Floats) -> Floats:
    """Give forward differences down and across, periodic: ``(2, height, width)``."""
    return np.stack([np.roll(image, -1, 0) - image, np.roll(image, -1, 1) - image])


def _adjoint(gradient: Floats) -> Floats:
    """Apply the transpose of ``_gradient``."""
    image: Floats = np.roll(gradient[0], 1, 0) - gradient[0] + np.roll(gradient[1], 1, 1) - gradient[1]
    return image


def _shrink(gradient: Floats, threshold: float) -> Floats:
    """Shorten each pixel's vector by ``threshold``, at most to 0."""
    length = np.sqrt(gradient[0] ** 2 + gradient[1] ** 2)
    kept: Floats = gradient * (np.maximum(length - threshold, 0) / np.maximum(length, 1e-300))
    return kept


def _power(values: Floats) -> float:
    """Give the sum of squares."""
    return float(np.vdot(values, values))


def _change(image: Floats, before: Floats) -> float:
    """Give the norm of the change from ``before`` to ``image``, relative to that of ``before``."""
    return float(np.linalg.norm(image - before) / max(float(np.linalg.norm(before)), 1e-30))
