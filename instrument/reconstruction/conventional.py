"""The inverse Hadamard transform, for an object at rest."""

import numpy as np

from instrument.patterns import walsh_matrix
from protocols import Floats, Integers


def inverse_hadamard(values: Floats, pairs: Integers, size: int) -> Floats:
    """Turn Hadamard coefficients into an image, O = sum I_k H_k / size^2.

    Coefficients of patterns that were not shown count as 0; those of a pattern shown more than once are averaged.

    Args:
        values: ``(n,)`` differential values I_H+ - I_H-.
        pairs: ``(n, 2)`` Walsh rows of each pattern, as from ``hadamard_order``.
        size: image pixels a side.

    Returns:
        ``(size, size)``, row = y (down), column = x.
    """
    flat = pairs[:, 0] * size + pairs[:, 1]
    shown = np.bincount(flat, minlength=size * size)
    coefficients = np.bincount(flat, weights=values, minlength=size * size) / np.maximum(shown, 1)
    walsh = walsh_matrix(size).astype(np.float64)
    image: Floats = walsh.T @ coefficients.reshape(size, size) @ walsh / size**2
    return image
