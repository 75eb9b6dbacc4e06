"""What valid frames say of the image, whatever the motion was: differences, fixed patterns, and their noise."""

from dataclasses import dataclass

import numpy as np

from instrument.numerics import smooth
from instrument.schemes import Scheme, image_rows_of
from protocols import Floats, Integers

_FEWEST = 8  # frames from which a drift of the light can be told
_LEAST_NOISE = 5e-4  # of the rms of the values: a run without noise is solved to this


@dataclass(frozen=True, eq=False)
class ImageValues:
    """Values of the valid frames, divided by the lamp's brightness. Each array begins with ``rows``, one a valid frame."""

    frame: Integers
    """``(rows,)``: index of the frame."""

    pairs: Integers
    """``(rows, 2)``: Walsh rows of its Hadamard pattern."""

    positive: Floats
    """``(rows,)``: I_H+."""

    negative: Floats
    """``(rows,)``: I_H-."""

    difference_variance: Floats
    """``(rows,)``: variance of I_H+ - I_H-."""

    fixed: Floats
    """``(rows, k)``: values of the patterns that measure position, in the order of their columns."""

    fixed_variance: Floats
    """``(rows, k)``: variance of those."""

    time_s: Floats
    """``(rows, 2 + k)``: when H+, H- and each position pattern were in their middle, from the first edge of the run on."""

    size: int
    """Pixels a side of the field."""

    photon_counts: bool
    """Whether values are photons."""

    noise: float
    """Standard deviation of a single value, rms over all."""

    @classmethod
    def of(
        cls,
        scheme: Scheme,
        *,
        frame: Integers,
        pairs: Integers,
        values: Floats,
        variance: Floats,
        time_s: Floats,
        lamp: Floats,
        size: int,
        photon_counts: bool,
    ) -> "ImageValues":
        """Take frames of a run.

        Of photons, I_H+ and I_H- get the variance of their sum, smoothed over frames, by halves: each count as its own variance
        would make low counts weigh more.

        Args:
            scheme: which column is which.
            frame: ``(rows,)`` index of each frame.
            pairs: ``(rows, 2)`` its Walsh rows.
            values: ``(rows, patterns_per_frame)`` light, finite.
            variance: of those.
            time_s: ``(rows, patterns_per_frame)``.
            lamp: ``(rows,)`` brightness of the lamp over its mean.
            size: pixels a side of the field.
            photon_counts: whether values are photons.

        Raises:
            InputError: a scheme without an image.
        """
        rows = image_rows_of(scheme)
        halves = variance[:, [rows.positive, rows.negative]]
        if photon_counts and len(values) >= _FEWEST:
            both = halves.sum(axis=1)
            halves = np.repeat(smooth(both, np.ones(len(both)), orders=(1,)).values[:, None] / 2, 2, axis=1)
        everything = variance.copy()
        everything[:, [rows.positive, rows.negative]] = halves
        floor = (_LEAST_NOISE * float(np.sqrt(np.mean(np.square(values))))) ** 2 + 1e-30
        everything = np.where(np.isfinite(everything), np.maximum(everything, floor), floor) / lamp[:, None] ** 2
        bright = values / lamp[:, None]
        fixed = fixed_columns(scheme)
        return cls(
            frame=frame,
            pairs=pairs,
            positive=bright[:, rows.positive],
            negative=bright[:, rows.negative],
            difference_variance=everything[:, rows.positive] + everything[:, rows.negative],
            fixed=bright[:, fixed],
            fixed_variance=everything[:, fixed],
            time_s=time_s[:, [rows.positive, rows.negative, *fixed.tolist()]],
            size=size,
            photon_counts=photon_counts,
            noise=float(np.sqrt(np.mean(everything))),
        )

    def __len__(self) -> int:
        """Rows."""
        return len(self.frame)

    @property
    def difference(self) -> Floats:
        """``(rows,)``: I_H = I_H+ - I_H-."""
        return self.positive - self.negative

    @property
    def difference_sigma(self) -> Floats:
        """``(rows,)``: standard deviation of that."""
        return np.sqrt(self.difference_variance)


def fixed_columns(scheme: Scheme) -> Integers:
    """Columns of the patterns that measure position, ascending. They are the same in every frame."""
    if scheme.position is None:
        return np.zeros(0, np.int64)
    return np.unique(scheme.position.columns).astype(np.int64)
