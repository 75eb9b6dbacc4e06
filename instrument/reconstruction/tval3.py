r"""TVAL3's model and method, for comparison: total variation by an augmented Lagrangian with alternating directions.

With D the gradient, w its copy in each pixel, nu and delta the multipliers of D u = w and A u = b, it minimises

    sum ||w|| - nu'(D u - w) + beta/2 ||D u - w||^2 - delta'(A u - b) + mu/2 ||A u - b||^2

in turn over w (exactly: shrinkage) and over u (one step down the gradient), then updates the multipliers. Without delta this is
the model TV + mu/2 ||A u - b||^2, for noisy values; with delta A u = b is enforced, for values without noise.

References:
    C. Li, W. Yin, H. Jiang, Y. Zhang, "An efficient augmented Lagrangian method with applications to total variation
    minimization", Comput. Optim. Appl. 56 (2013) 507-530.
    J. Barzilai, J. M. Borwein, IMA J. Numer. Anal. 8 (1988) 141, equation 6 (length of the step).
    H. Zhang, W. W. Hager, SIAM J. Optim. 14 (2004) 1043 (line search that lets the objective rise now and then).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from instrument.reconstruction.operator import Operator, largest_eigenvalue
from protocols import Floats, Singles

_ABOVE = 1.02  # the power method approaches the largest eigenvalue from below
_RANGE = (0.5, 1.5)  # of the scaled values, largest less smallest
_ARMIJO = 1e-5
_SHORTER = 0.6
_TRIALS = 5
_MEMORY = 0.9995  # weight of earlier objectives in the line search
_FASTER = 2.0  # mu and beta at each update of the multipliers, until they are what was asked for


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
    first_mu: float | None = None,
    first_beta: float | None = None,
    exact: bool = False,
    nonnegative: bool = True,
    tolerance: float = 1e-6,
    inner_tolerance: float = 1e-3,
    iterations: int = 1025,
    inner_iterations: int = 10,
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
        first_mu: mu to begin with, doubled at each update of the multipliers (continuation); None for ``mu`` throughout.
        first_beta: the same for beta.
        exact: enforce A x = b by a multiplier: for values without noise.
        nonnegative: x >= 0.
        tolerance: relative change of the image from one update of the multipliers to the next at which it ends.
        inner_tolerance: relative change of the image in one step at which the multipliers are updated.
        iterations: steps of the image at most, in all.
        inner_iterations: steps at most between updates of the multipliers.
        watch: told of each image, on the scale of the data.
    """
    scaled = _Scaled.of(operator, values)
    search = _Search(scaled, nonnegative=nonnegative, exact=exact)
    now_mu, now_beta = min(first_mu or mu, mu), min(first_beta or beta, beta)
    spent = 0
    while spent < iterations:
        before = search.image
        search.weights(now_mu, now_beta)
        for _ in range(min(inner_iterations, iterations - spent)):
            last = search.image
            search.step()
            spent += 1
            if watch is not None:
                watch(search.image / scaled.stretch)
            if _change(search.image, last) < inner_tolerance:
                break
        search.update_multipliers()
        settled = now_mu >= mu and now_beta >= beta
        if settled and _change(search.image, before) < tolerance:
            break
        now_mu, now_beta = min(_FASTER * now_mu, mu), min(_FASTER * now_beta, beta)
    image: Singles = (search.image / scaled.stretch).astype(np.float32)
    residual = operator.matvec(image.ravel()) - values
    misfit = float(np.sqrt(np.mean(np.square(residual)))) if residual.size else 0.0
    return AlState(image, misfit, spent, weight=scaled.norm**2 / (mu * scaled.stretch))


class _Search:
    """The image with all that goes with it, and the steps that lower the augmented Lagrangian."""

    def __init__(self, scaled: _Scaled, *, nonnegative: bool, exact: bool) -> None:
        self.scaled, self.nonnegative, self.exact = scaled, nonnegative, exact
        self.image: Floats = scaled.back(scaled.values)
        if nonnegative:
            self.image = np.maximum(self.image, 0)
        self.seen: Floats = scaled.forward(self.image)
        self.slope: Floats = _gradient(self.image)
        self.nu: Floats = np.zeros_like(self.slope)
        self.delta: Floats = np.zeros_like(scaled.values)
        self.copy: Floats = self.slope
        self.length = 1.0
        self.mu, self.beta = 1.0, 1.0

    def weights(self, mu: float, beta: float) -> None:
        """Begin with these weights: the line search forgets what was, and w follows."""
        if (mu, beta) != (self.mu, self.beta):
            self.length = 1 / (mu + 8 * beta)  # 8: the largest eigenvalue of D'D
        self.mu, self.beta = mu, beta
        self.copy = _shrink(self.slope - self.nu / beta, 1 / beta)
        self.allowed, self.mass = self._objective(self.slope, self.seen), 1.0

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
        mass = _MEMORY * self.mass + 1
        self.allowed = (_MEMORY * self.mass * self.allowed + objective) / mass
        self.mass = mass

    def update_multipliers(self) -> None:
        """Add what still separates D u from w and, where values are exact, A u from b."""
        self.nu = self.nu - self.beta * (self.slope - self.copy)
        if self.exact:
            self.delta = self.delta - self.mu * (self.seen - self.scaled.values)

    def _moved(self, length: float, down: Floats) -> tuple[Floats, Floats, Floats]:
        """Give the image after a step of this length, its values and its gradient."""
        image: Floats = self.image - length * down
        if self.nonnegative:
            image = np.maximum(image, 0)
        return image, self.scaled.forward(image), _gradient(image)

    def _down(self) -> Floats:
        """Give the gradient of the augmented Lagrangian by u."""
        pull = self.scaled.back(self.mu * (self.seen - self.scaled.values) - self.delta)
        return pull + _adjoint(self.beta * (self.slope - self.copy) - self.nu)

    def _objective(self, slope: Floats, seen: Floats) -> float:
        """Value of the augmented Lagrangian at an image with this gradient and these values."""
        apart, residual = slope - self.copy, seen - self.scaled.values
        total = float(np.sqrt(self.copy[0] ** 2 + self.copy[1] ** 2).sum())
        total += self.beta / 2 * _power(apart) - float(np.vdot(self.nu, apart))
        return total + self.mu / 2 * _power(residual) - float(np.vdot(self.delta, residual))


def periodic_tv(image: Floats) -> float:
    """Isotropic total variation with the image continued beyond its border by its other side."""
    down, across = _gradient(image)
    return float(np.sqrt(down**2 + across**2).sum())


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
