"""The inverse Hadamard transform, for an object at rest."""

import numpy as np

from instrument.patterns import HadamardOrder, hadamard_order, walsh_matrix
from protocols import Floats, Integers


def inverse_hadamard(values: Floats, size: int, order: HadamardOrder = "tv") -> Floats:
    """Turn Hadamard coefficients into an image; patterns that were not measured count as 0.

    Args:
        values: ``(n,)`` differential values I_H+ - I_H-, from the order's first pattern on; n at most ``size ** 2``.
        size: image pixels a side.
        order: in which order the patterns were shown.

    Returns:
        ``(size, size)``: O = sum I_k H_k / size^2, row = y (down), column = x.

    Raises:
        ValueError: more values than patterns.
    """
    if len(values) > size * size:
        raise ValueError(f"{len(values)} values, but there are {size * size} patterns of {size} x {size} pixels")
    return inverse_walsh(values, hadamard_order(size, order, len(values)), size)


def inverse_walsh(values: Floats, pairs: Integers, size: int) -> Floats:
    """The same for patterns listed as pairs of Walsh rows; values of a pattern shown more than once are averaged."""
    flat = pairs[:, 0] * size + pairs[:, 1]
    shown = np.bincount(flat, minlength=size * size)
    coefficients = np.bincount(flat, weights=values, minlength=size * size) / np.maximum(shown, 1)
    walsh = walsh_matrix(size).astype(np.float64)
    image: Floats = walsh.T @ coefficients.reshape(size, size) @ walsh / size**2
    return image
