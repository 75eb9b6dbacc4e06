"""Differential ghost imaging, which gives an image without a solver."""

import numpy as np

from instrument.numerics import Operator
from protocols import Singles


def ghost_image(operator: Operator, values: Singles, pattern_sum: Singles) -> Singles:
    """Correlate values with patterns: G(x) = <B P(x)> - (<B> / <R>) <R P(x)>.

    Args:
        operator: patterns P as rows, each shifted by the displacement of the object.
        values: ``(rows,)`` values B.
        pattern_sum: ``(rows,)`` light R of each pattern without an object.

    Returns:
        The image G, ``(height, width)``, in units of B times P. It has no absolute scale.

    References:
        F. Ferri et al., Phys. Rev. Lett. 104 (2010) 253603, equation 8.
    """
    ratio = values.mean() / pattern_sum.mean()
    weight = ((values - ratio * pattern_sum) / np.float32(max(1, len(values)))).astype(np.float32)
    return operator.rmatvec(weight).reshape(operator.image_shapes[0])
