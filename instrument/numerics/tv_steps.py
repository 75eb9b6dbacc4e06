"""Total variation of an image and both half steps of its primal-dual iteration, each one pass over the image.

The gradient of a pixel is taken four times, from each of its corners: to the pixel below or above, and to the right or left.
The mean of the four norms treats all directions of an edge alike; forward differences alone round off two of four corners.
With K half of all four gradients, K'K is at most 8, as for one of them.

A dual variable is ``(8, height, width)``: of each corner, along y and x. Differences beyond the border are 0.

References:
    Condat, SIAM J. Imaging Sci. 10 (2017) 1258-1290: on how total variation is discretised.
"""

import numpy as np

from instrument.numerics.compiled import compiled
from protocols import Singles

CORNERS = 4
_HALF = np.float32(0.5)


@compiled("void(f4[:, ::1], f4[:, :, ::1], f4[:, ::1], f4, f4)", sums_reordered=True)
def descend(image: Singles, dual: Singles, slope: Singles, step: float, pull: float) -> None:
    """Replace ``slope`` by where the image goes next: image - step * slope - pull * K' dual, at least 0.

    Args:
        image: ``(height, width)``.
        dual: ``(8, height, width)``.
        slope: ``(height, width)``: gradient of the misfit; overwritten.
        step: length of the step.
        pull: that of the dual's.
    """
    height, width = image.shape
    inflow = np.empty(width, np.float32)
    for y in range(height):
        for x in range(width):
            inflow[x] = dual[2, y, x] + dual[3, y, x] - dual[0, y, x] - dual[1, y, x]
            inflow[x] += dual[5, y, x] + dual[7, y, x] - dual[4, y, x] - dual[6, y, x]
        if y > 0:
            for x in range(width):
                inflow[x] += dual[0, y - 1, x] + dual[1, y - 1, x]
        if y + 1 < height:
            for x in range(width):
                inflow[x] -= dual[2, y + 1, x] + dual[3, y + 1, x]
        for x in range(1, width):
            inflow[x] += dual[4, y, x - 1] + dual[6, y, x - 1]
        for x in range(width - 1):
            inflow[x] -= dual[5, y, x + 1] + dual[7, y, x + 1]
        for x in range(width):
            slope[y, x] = max(image[y, x] - step * slope[y, x] - pull * _HALF * inflow[x], np.float32(0))


@compiled("void(f4[:, ::1], f4[:, :, ::1], f4[:, ::1], f4[:, :, ::1], f4, f4)", sums_reordered=True)
def ascend(  # noqa: PLR0917
    image: Singles, dual: Singles, ahead: Singles, radius: Singles, step: float, relaxation: float
) -> None:
    """Move dual and image on: to dual + step * K(2 ahead - image), no longer than ``radius``, and to ``ahead``, over-relaxed.

    Args:
        image: ``(height, width)``.
        dual: ``(8, height, width)``: down, down, up, up; then right, left, right, left.
        ahead: ``(height, width)`` as ``descend`` gives it.
        radius: ``(4, height, width)``: longest dual vector of each corner.
        step: length of the step.
        relaxation: 1 for none.
    """
    height, width = image.shape
    there = 2 * ahead - image
    level = np.zeros((2, width), np.float32)  # difference to the pixel above, and to the one below
    beside = np.zeros(width + 1, np.float32)
    for y in range(height):
        for x in range(width):
            level[0, x] = level[1, x]
            level[1, x] = 0
        if y + 1 < height:
            for x in range(width):
                level[1, x] = step * _HALF * (there[y + 1, x] - there[y, x])
        for x in range(1, width):
            beside[x] = step * _HALF * (there[y, x] - there[y, x - 1])
        for corner in range(CORNERS):
            along, side = 1 - corner // 2, 1 - corner % 2
            for x in range(width):
                down, across = dual[corner, y, x] + level[along, x], dual[4 + corner, y, x] + beside[x + side]
                length = np.sqrt(down * down + across * across + np.float32(1e-30))
                shorter = min(radius[corner, y, x] / length, np.float32(1))
                dual[corner, y, x] += relaxation * (shorter * down - dual[corner, y, x])
                dual[4 + corner, y, x] += relaxation * (shorter * across - dual[4 + corner, y, x])
    for y in range(height):
        for x in range(width):
            image[y, x] += relaxation * (ahead[y, x] - image[y, x])


def slopes(image: Singles) -> Singles:
    """Norms of an image's gradients: ``(4, height, width)``, of each corner."""
    down, across = np.diff(image, axis=0) ** 2, np.diff(image) ** 2
    squares = np.zeros((CORNERS, *image.shape), np.float32)
    squares[:2, :-1] += down
    squares[2:, 1:] += down
    squares[::2, :, :-1] += across
    squares[1::2, :, 1:] += across
    return np.sqrt(squares)
