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
    """``(k,)``: ascending, without frame 0, the last one included."""

    covariance_px2: Floats
    """``(2, k, k)``: along x and along y, of the displacements from frame 0, px^2."""

    @classmethod
    def of(cls, fits: Sequence[Smooth], sigma_px: Floats) -> Self:
        """Take it from the smoother.

        Args:
            fits: of x and y.
            sigma_px: ``(frames, 2)`` standard deviation that is stated for the path; where it is larger than the smoother's own,
                the covariance is enlarged with it.
        """
        frames = len(sigma_px)
        frame = np.unique(np.linspace(0, frames - 1, min(frames, _KNOTS)).round().astype(np.int64))[1:]
        covariances: list[Floats] = []
        for axis, fit in enumerate(fits):
            covariance = fit.covariance_to_first(frame)
            ratio = sigma_px[frame, axis] / np.sqrt(np.maximum(np.diag(covariance), 1e-300))
            covariances.append(covariance * np.outer(ratio, ratio))
        return cls(frame, np.stack(covariances))
