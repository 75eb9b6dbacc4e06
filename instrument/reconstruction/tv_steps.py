"""Both half steps of the primal-dual iteration for total variation, each one pass over the image.

The gradient is of forward differences, 0 beyond the last row and column: there ``dual`` is 0 and stays so.
"""

import numpy as np

from instrument.compiled import compiled
from protocols import Singles


@compiled("void(f4[:, ::1], f4[:, :, ::1], f4[:, ::1], f4, f4)", sums_reordered=True)
def descend(image: Singles, dual: Singles, slope: Singles, step: float, pull: float) -> None:
    """Replace ``slope`` by where the image goes next: image - step * slope - pull * D' dual, at least 0.

    Args:
        image: ``(height, width)``.
        dual: ``(2, height, width)``, down and across.
        slope: ``(height, width)``: gradient of the misfit; overwritten.
        step: length of the step.
        pull: that of the dual's.
    """
    height, width = image.shape
    for y in range(height):
        for x in range(width):
            inflow = -dual[0, y, x] - dual[1, y, x]
            if y > 0:
                inflow += dual[0, y - 1, x]
            if x > 0:
                inflow += dual[1, y, x - 1]
            slope[y, x] = max(image[y, x] - step * slope[y, x] - pull * inflow, np.float32(0))


@compiled("void(f4[:, ::1], f4[:, :, ::1], f4[:, ::1], f4[:, ::1], f4, f4)", sums_reordered=True)
def ascend(  # noqa: PLR0917
    image: Singles, dual: Singles, ahead: Singles, radius: Singles, step: float, relaxation: float
) -> None:
    """Move dual and image on: to dual + step * D(2 ahead - image), no longer than ``radius``, and to ``ahead``, over-relaxed.

    Args:
        image: ``(height, width)``.
        dual: ``(2, height, width)``.
        ahead: ``(height, width)`` as ``descend`` gives it.
        radius: ``(height, width)``: longest dual vector of each pixel.
        step: length of the step.
        relaxation: 1 for none.
    """
    height, width = image.shape
    for y in range(height):
        for x in range(width):
            here = 2 * ahead[y, x] - image[y, x]
            down, across = dual[0, y, x], dual[1, y, x]
            if y + 1 < height:
                down += step * (2 * ahead[y + 1, x] - image[y + 1, x] - here)
            if x + 1 < width:
                across += step * (2 * ahead[y, x + 1] - image[y, x + 1] - here)
            shorter = min(radius[y, x] / np.sqrt(down * down + across * across + np.float32(1e-30)), np.float32(1))
            dual[0, y, x] += relaxation * (shorter * down - dual[0, y, x])
            dual[1, y, x] += relaxation * (shorter * across - dual[1, y, x])
    for y in range(height):
        for x in range(width):
            image[y, x] += relaxation * (ahead[y, x] - image[y, x])
