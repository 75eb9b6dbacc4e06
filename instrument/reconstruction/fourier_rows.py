"""The four Fourier values as rows of the measurement.

What the grey fringes see of an object is known to great precision, each fringe being shown in every frame, and says next to
nothing of its shape. It would make the system so ill-conditioned that no first-order solver moves. So values and rows are freed
of all that goes as a constant, a cosine and a sine of the object's phase; what is left is what the dithering of the fringes sees:
a fixed binary noise, drawn across the object by its own motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from instrument.reconstruction.correlation import FixedPatterns
from protocols import Floats, Singles


@dataclass(frozen=True, eq=False)
class FourierRows:
    """Rows of fixed patterns at many places, whitened; see the module."""

    fixed: FixedPatterns
    """The patterns, ``n`` of them."""

    sampling: csr_array
    """``(frames n, n width width)``: reads their maps, over the noise."""

    grey: Singles
    """``(n, frames, 3)``: orthonormal series that are taken off."""

    @classmethod
    def of(
        cls, fixed: FixedPatterns, places_px: Floats, sigma: Floats, frequency_per_px: float, axes: Sequence[int]
    ) -> "FourierRows":
        """Prepare.

        Args:
            fixed: n fringes.
            places_px: ``(frames, n, 2)`` x, y: of the object during each.
            sigma: ``(frames, n)``: noise of the values.
            frequency_per_px: of the fringes.
            axes: along which axis each fringe varies: 0 for x, 1 for y.
        """
        along = np.stack([places_px[:, column, axis] for column, axis in enumerate(axes)])
        angle = 2 * np.pi * frequency_per_px * along
        series = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=-1) / sigma.T[..., None]
        grey, _ = np.linalg.qr(series)
        sampling = csr_array(fixed.sampling(places_px).multiply((1 / sigma).astype(np.float32).reshape(-1, 1)))
        return cls(fixed, sampling, grey.astype(np.float32))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and pixels."""
        height, width = self.image_shape
        return self.sampling.shape[0], height * width

    @property
    def image_shape(self) -> tuple[int, int]:
        """Height and width of the unknown image."""
        return self.fixed.region.shape

    def matvec(self, image: Singles) -> Singles:
        """Values of an image: ``(pixels,)`` to ``(rows,)``."""
        return self.dithering(self.sampling @ self.fixed.maps(image.reshape(self.image_shape)).ravel())

    def rmatvec(self, values: Singles) -> Singles:
        """The transpose: ``(rows,)`` to ``(pixels,)``."""
        width = self.fixed.width
        maps: Singles = (self.sampling.T @ self.dithering(values)).astype(np.float32).reshape(-1, width, width)
        return self.fixed.image(maps).ravel()

    def dithering(self, values: Singles) -> Singles:
        """Free ``(rows,)`` whitened values, frame by frame, of what the grey fringes see."""
        series = values.reshape(-1, len(self.grey)).T[..., None]
        left = series - self.grey @ (self.grey.swapaxes(1, 2) @ series)
        return left[..., 0].T.ravel().astype(np.float32, copy=False)
