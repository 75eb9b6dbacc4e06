"""An image out of focus."""

import math
from typing import Final

import numpy as np

from protocols import Floats, InputError
from sim_backends.bench.image import AreaImage
from sim_backends.bench.pictures import MOST_CELLS

_WIDTHS: Final = 4.0
"""So many standard deviations to either side are kept of the Gaussian: 0.1 % of its variance is beyond."""

_FINEST: Final = 0.7
"""Cells are divided until the standard deviation is so many cells: below, samples of a Gaussian have another width."""

_MOST_PARTS: Final = 4
"""A cell is divided into so many a side at most. What is blurred by less than a sixth of a cell stays as sharp as it is."""


def blurred(image: AreaImage, sigma_px: float) -> AreaImage:
    """Convolve an image with a Gaussian of ``sigma_px``, in image pixels. It keeps its light and its centre.

    Raises:
        InputError: the image has so fine cells that the Gaussian would cover too many of them.
    """
    if sigma_px == 0:
        return image
    from scipy.ndimage import gaussian_filter  # noqa: PLC0415  (slow to load: only who blurs needs it)

    parts = min(_MOST_PARTS, math.ceil(_FINEST * image.cell_px / sigma_px))
    cell_px = image.cell_px / parts
    sigma = sigma_px / cell_px
    border = math.ceil(_WIDTHS * sigma)
    rows, columns = (side * parts + 2 * border for side in image.cells.shape)
    if rows * columns > MOST_CELLS:
        raise InputError(
            device="bench",
            saw=f"blur_px = {sigma_px:g} on a picture with cells of {cell_px:.3g} px: {columns} x {rows} of them",
            expected=f"{MOST_CELLS} cells at most",
            remedy="lower blur_px in [scene], or give a picture with fewer pixels",
        )
    cells = np.pad(image.cells.repeat(parts, 0).repeat(parts, 1), border)
    spread: Floats = gaussian_filter(cells, sigma, mode="constant", radius=border)
    return AreaImage(spread, cell_px, image.left_px - border * cell_px, image.top_px - border * cell_px)
