"""How the errors of a smoothed path hang together from frame to frame: what is fitted to the path needs it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self

import numpy as np

from instrument.numerics import Smooth
from protocols import Floats, Integers

_KNOTS: Final = 33


@dataclass(frozen=True, eq=False)
class PathCovariance:
    """Covariance of a path's displacements at some of its frames."""

    frame: Integers
    """``(k,)``: ascending, after the frame that displacements are relative to, the last one included."""

    covariance_px2: Floats
    """``(2, k, k)``: along x and along y, of the displacements, px^2."""

    @classmethod
    def of(cls, fits: Sequence[Smooth], sigma_px: Floats, reference_frame: int = 0) -> Self:
        """Take it from the smoother.

        Args:
            fits: of x and y.
            sigma_px: ``(frames, 2)`` standard deviation that is stated for the path; where it is larger than the smoother's own,
                the covariance is enlarged with it.
            reference_frame: frame that displacements are relative to.
        """
        last, count = len(sigma_px) - 1, len(sigma_px) - reference_frame
        frame = np.unique(np.linspace(reference_frame, last, min(count, _KNOTS)).round().astype(np.int64))[1:]
        covariances: list[Floats] = []
        for axis, fit in enumerate(fits):
            covariance = fit.covariance_to(reference_frame, frame)
            ratio = sigma_px[frame, axis] / np.sqrt(np.maximum(np.diag(covariance), 1e-300))
            covariances.append(covariance * np.outer(ratio, ratio))
        return cls(frame, np.stack(covariances))
