"""The bound on the relaxation rho below which the TV iteration is proved to converge, for several sets of rows.

``python -m benchmarks.relaxation``, from the repository's root. With tau, sigma and K of ``instrument.numerics.tv`` and L the
largest eigenvalue of A'A, the bound is 2 - mu / 2, mu being the largest eigenvalue of (1 / tau - sigma K'K)^-1 A'A / L.

References:
    L. Condat, J. Optim. Theory Appl. 158 (2013) 460, theorem 3.1, in the metric of the iteration.
"""

import numpy as np

from instrument.numerics import EIGENVALUE_MARGIN, Operator, largest_eigenvalue
from instrument.patterns import hadamard_order
from instrument.reconstruction import Field, ShiftedHadamard
from protocols import Floats

INVERSE_TAU, SIGMA = 2.5, 0.25
POWER_STEPS, CONJUGATE_STEPS = 40, 60


def metric(image: Floats) -> Floats:
    """Apply 1 / tau - sigma K'K; the four halved gradients together have the K'K of one whole one."""
    laplacian = np.zeros_like(image)
    down, right = np.diff(image, axis=0), np.diff(image, axis=1)
    laplacian[:-1] -= down
    laplacian[1:] += down
    laplacian[:, :-1] -= right
    laplacian[:, 1:] += right
    return INVERSE_TAU * image - SIGMA * laplacian


def solved(right_side: Floats) -> Floats:
    """Apply the inverse of ``metric``, by conjugate gradients."""
    image, residual = np.zeros_like(right_side), right_side.copy()
    direction, power = residual.copy(), float(np.vdot(residual, residual))
    for _ in range(CONJUGATE_STEPS):
        product = metric(direction)
        length = power / float(np.vdot(direction, product))
        image += length * direction
        residual -= length * product
        last, power = power, float(np.vdot(residual, residual))
        if power < 1e-20:
            break
        direction = residual + power / last * direction
    return image


def bound(rows: Operator) -> float:
    """Give the bound on rho, by the power method."""
    largest = largest_eigenvalue(rows) * EIGENVALUE_MARGIN
    image: Floats = np.random.default_rng(0).random(rows.image_shapes[0])
    mu = 0.0
    for _ in range(POWER_STEPS):
        image /= np.linalg.norm(image)
        seen = rows.rmatvec(rows.matvec(image.astype(np.float32).ravel()))
        moved = solved(seen.reshape(rows.image_shapes[0]).astype(np.float64) / largest)
        mu, image = float(np.vdot(image, moved)), moved
    return 2 - mu / 2


def main() -> None:
    """Print one line for each set of rows."""
    for size, count, end_px in ((128, 1666, 0), (128, 1666, 20), (64, 512, 0), (64, 4096, 20), (64, 4096, 0)):
        places_px: Floats = np.linspace(0, end_px, count)[:, None] * np.array([1.0, 0.5])
        rows = ShiftedHadamard.single(hadamard_order(size, "tv", count), places_px, Field(size))
        print(f"{count} patterns of {size} x {size}, moved by {end_px}, {end_px / 2:g} px: rho below {bound(rows):.2f}")


if __name__ == "__main__":
    main()
