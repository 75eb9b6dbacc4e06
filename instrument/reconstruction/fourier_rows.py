"""The four Fourier values as rows of the measurement.

The values of grey fringes are known precisely, as each fringe is shown in every frame, but say next to nothing of the object's
shape. As rows they would make the system so ill-conditioned that a first-order solver could not converge. Values and rows are
therefore projected on the complement of the constant, the cosine and the sine of the object's phase. What remains stems from the
dithering of the fringes: a fixed binary noise that the object's own motion carries across it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from instrument.reconstruction.correlation import FixedPatterns
from protocols import Floats, Singles


@dataclass(frozen=True, eq=False)
class FourierRows:
    """Whitened rows of n fixed patterns at many displacements, without what grey fringes would give; see the module."""

    fixed: FixedPatterns
    """The n patterns."""

    sampling: csr_array
    """``(frames n, n width width)``: matrix that takes correlation maps to values over their noise."""

    grey: Singles
    """``(n, frames, 3)``: orthonormal series of each pattern that are projected out."""

    @classmethod
    def of(
        cls, fixed: FixedPatterns, places_px: Floats, sigma: Floats, frequency_per_px: float, axes: Sequence[int]
    ) -> "FourierRows":
        """Prepare the rows of a run.

        Args:
            fixed: the n fringes.
            places_px: ``(frames, n, 2)`` displacement (x, y) of the object during each fringe.
            sigma: ``(frames, n)`` standard deviation of each value.
            frequency_per_px: spatial frequency of the fringes, in periods per px.
            axes: axis along which each fringe varies, 0 for x and 1 for y.
        """
        along = np.stack([places_px[:, column, axis] for column, axis in enumerate(axes)])
        angle = 2 * np.pi * frequency_per_px * along
        series = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=-1) / sigma.T[..., None]
        grey, _ = np.linalg.qr(series)
        sampling = csr_array(fixed.sampling(places_px).multiply((1 / sigma).astype(np.float32).reshape(-1, 1)))
        return cls(fixed, sampling, grey.astype(np.float32))

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of pixels."""
        height, width = self.image_shape
        return self.sampling.shape[0], height * width

    @property
    def image_shapes(self) -> tuple[tuple[int, int]]:
        """Height and width of the one unknown image, in image pixels."""
        return (self.image_shape,)

    @property
    def image_shape(self) -> tuple[int, int]:
        """Height and width of the unknown image, in image pixels."""
        height, width = self.fixed.region.shape
        return height * self.fixed.field.grid, width * self.fixed.field.grid

    def matvec(self, image: Singles) -> Singles:
        """Give the values of an image: ``(pixels,)`` to ``(rows,)``."""
        return self.dithering(self.sampling @ self.fixed.maps(image.reshape(self.image_shape)).ravel())

    def rmatvec(self, values: Singles) -> Singles:
        """Apply the transpose: ``(rows,)`` to ``(pixels,)``."""
        width = self.fixed.width
        maps: Singles = (self.sampling.T @ self.dithering(values)).astype(np.float32).reshape(-1, width, width)
        return self.fixed.image(maps).ravel()

    def dithering(self, values: Singles) -> Singles:
        """Project ``(rows,)`` whitened values, frame by frame, on what the dithering contributes."""
        series = values.reshape(-1, len(self.grey)).T[..., None]
        left = series - self.grey @ (self.grey.swapaxes(1, 2) @ series)
        return left[..., 0].T.ravel().astype(np.float32, copy=False)
