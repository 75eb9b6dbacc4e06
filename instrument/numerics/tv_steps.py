"""The total variation of an image, and the two half steps of its primal-dual iteration.

The gradient of a pixel is taken four times, once from each of its corners: to the pixel below or above, and to the right or left.
The mean of the four norms treats all directions of an edge alike; forward differences alone round off two of four corners.
Differences beyond the image's border are 0.

K is half of all four gradients, so that K'K is at most 8, as it is for one gradient. A dual variable has the shape of K x,
``(2, 4, height, width)``: the component along y or x, then the corner.

References:
    L. Condat, SIAM J. Imaging Sci. 10 (2017) 1258-1290: how total variation is discretised.
"""

from typing import Final

import numpy as np

from instrument.numerics.compiled import compiled, inlined
from protocols import Singles

CORNERS: Final = 4
"""Number of gradients of a pixel."""

K_SQUARED: Final = 8.0
"""Upper bound of the largest eigenvalue of K'K."""

_ALONG_Y, _ALONG_X = 0, 1
_BELOW_RIGHT, _BELOW_LEFT, _ABOVE_RIGHT, _ABOVE_LEFT = 0, 1, 2, 3
_HALF = np.float32(0.5)


@inlined
def _adjoint_row(dual: Singles, y: int, row: Singles) -> None:
    """Write row ``y`` of 2 K' dual: what each difference adds to its far pixel, it takes from its near one."""
    along_y, along_x = dual[_ALONG_Y], dual[_ALONG_X]
    height, width = along_y.shape[1:]
    for x in range(width):
        row[x] = along_y[_ABOVE_RIGHT, y, x] + along_y[_ABOVE_LEFT, y, x]
        row[x] -= along_y[_BELOW_RIGHT, y, x] + along_y[_BELOW_LEFT, y, x]
        row[x] += along_x[_BELOW_LEFT, y, x] + along_x[_ABOVE_LEFT, y, x]
        row[x] -= along_x[_BELOW_RIGHT, y, x] + along_x[_ABOVE_RIGHT, y, x]
    if y > 0:
        for x in range(width):
            row[x] += along_y[_BELOW_RIGHT, y - 1, x] + along_y[_BELOW_LEFT, y - 1, x]
    if y + 1 < height:
        for x in range(width):
            row[x] -= along_y[_ABOVE_RIGHT, y + 1, x] + along_y[_ABOVE_LEFT, y + 1, x]
    for x in range(1, width):
        row[x] += along_x[_BELOW_RIGHT, y, x - 1] + along_x[_ABOVE_RIGHT, y, x - 1]
    for x in range(width - 1):
        row[x] -= along_x[_BELOW_LEFT, y, x + 1] + along_x[_ABOVE_LEFT, y, x + 1]


@compiled("void(f4[:, ::1], f4[:, :, :, ::1], f4[:, ::1], f4, f4)", sums_reordered=True)
def primal_step(image: Singles, dual: Singles, gradient: Singles, tau_data: float, tau: float) -> None:
    """Replace ``gradient`` by the primal proposal: max(0, image - tau_data gradient - tau K' dual).

    Args:
        image: ``(height, width)``.
        dual: ``(2, 4, height, width)``.
        gradient: ``(height, width)`` gradient of the data term at ``image``; overwritten.
        tau_data: step size for the data term.
        tau: step size for the dual variable.
    """
    height, width = image.shape
    adjoint = np.empty(width, np.float32)
    for y in range(height):
        _adjoint_row(dual, y, adjoint)
        for x in range(width):
            gradient[y, x] = max(image[y, x] - tau_data * gradient[y, x] - tau * _HALF * adjoint[x], np.float32(0))


@compiled("void(f4[:, ::1], f4[:, :, :, ::1], f4[:, ::1], f4[:, :, ::1], f4, f4)", sums_reordered=True)
def dual_step(  # noqa: PLR0917
    image: Singles, dual: Singles, proposal: Singles, bound: Singles, sigma: float, rho: float
) -> None:
    """Move the dual variable and then the image, both over-relaxed.

    The dual proposal is dual + sigma K (2 proposal - image), each corner's vector shortened to its bound. Dual and image then
    move to rho times their proposal plus 1 - rho times what they were.

    Args:
        image: ``(height, width)``; overwritten.
        dual: ``(2, 4, height, width)``; overwritten.
        proposal: ``(height, width)`` as ``primal_step`` gives it.
        bound: ``(4, height, width)`` largest length of each corner's dual vector.
        sigma: step size of the dual variable.
        rho: relaxation; 1 takes the proposals as they are.
    """
    height, width = image.shape
    along_y, along_x = dual[_ALONG_Y], dual[_ALONG_X]
    mirrored = 2 * proposal - image
    # sigma K of the mirrored image in one row: the differences to the rows above and below, and, at x, that from x - 1 to x.
    vertical = np.zeros((2, width), np.float32)
    horizontal = np.zeros(width + 1, np.float32)
    above, below = 0, 1
    for y in range(height):
        for x in range(width):
            vertical[above, x] = vertical[below, x]
            vertical[below, x] = 0
        if y + 1 < height:
            for x in range(width):
                vertical[below, x] = sigma * _HALF * (mirrored[y + 1, x] - mirrored[y, x])
        for x in range(1, width):
            horizontal[x] = sigma * _HALF * (mirrored[y, x] - mirrored[y, x - 1])
        for corner in range(CORNERS):
            neighbour = below if corner < _ABOVE_RIGHT else above
            shift = 1 - corner % 2  # 1 for the corners on the right, whose difference stands at x + 1
            for x in range(width):
                down = along_y[corner, y, x] + vertical[neighbour, x]
                right = along_x[corner, y, x] + horizontal[x + shift]
                length = np.sqrt(down * down + right * right + np.float32(1e-30))
                scale = min(bound[corner, y, x] / length, np.float32(1))
                along_y[corner, y, x] += rho * (scale * down - along_y[corner, y, x])
                along_x[corner, y, x] += rho * (scale * right - along_x[corner, y, x])
    for y in range(height):
        for x in range(width):
            image[y, x] += rho * (proposal[y, x] - image[y, x])


def gradient_norms(image: Singles) -> Singles:
    """Give the norms of the four gradients of each pixel of ``(height, width)``: ``(4, height, width)``, one for each corner."""
    down, right = np.diff(image, axis=0) ** 2, np.diff(image) ** 2
    squares = np.zeros((CORNERS, *image.shape), np.float32)
    squares[[_BELOW_RIGHT, _BELOW_LEFT], :-1] += down
    squares[[_ABOVE_RIGHT, _ABOVE_LEFT], 1:] += down
    squares[[_BELOW_RIGHT, _ABOVE_RIGHT], :, :-1] += right
    squares[[_BELOW_LEFT, _ABOVE_LEFT], :, 1:] += right
    return np.sqrt(squares)


def close_border(dual: Singles) -> None:
    """Set the components of a dual variable to 0 that point across the border, where every difference is 0.

    A dual variable that was cut out of a larger one has some, and the iteration would keep them for ever.

    Args:
        dual: ``(2, 4, height, width)``; changed in place.
    """
    dual[_ALONG_Y, [_BELOW_RIGHT, _BELOW_LEFT], -1] = 0
    dual[_ALONG_Y, [_ABOVE_RIGHT, _ABOVE_LEFT], 0] = 0
    dual[_ALONG_X, [_BELOW_RIGHT, _ABOVE_RIGHT], :, -1] = 0
    dual[_ALONG_X, [_BELOW_LEFT, _ABOVE_LEFT], :, 0] = 0
