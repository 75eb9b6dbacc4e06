"""What the valid frames say of the image, whatever the motion: differences, values of fixed patterns, and their noise."""

from dataclasses import dataclass, replace

import numpy as np

from instrument.numerics import smooth
from instrument.schemes import Scheme, image_rows_of
from protocols import Floats, Integers

_FEWEST_FRAMES = 8  # below which variances are not smoothed
_LEAST_NOISE = 5e-4  # noise assumed at least, over the rms value, so that values without noise can be solved for


@dataclass(frozen=True, eq=False)
class ImageValues:
    """Values of the valid frames, divided by the lamp's brightness. Each array begins with ``rows``, one for each valid frame."""

    frame: Integers
    """``(rows,)``: index of the frame."""

    pairs: Integers
    """``(rows, 2)``: Walsh rows of the frame's Hadamard pattern."""

    positive: Floats
    """``(rows,)``: value I_H+."""

    negative: Floats
    """``(rows,)``: value I_H-."""

    difference_variance: Floats
    """``(rows,)``: variance of I_H+ - I_H-."""

    fixed: Floats
    """``(rows, k)``: values of the patterns that measure position, in the order of their columns."""

    fixed_variance: Floats
    """``(rows, k)``: variance of ``fixed``."""

    time_s: Floats
    """``(rows, 2 + k)``: when H+, H- and each position pattern were in their middle, from the first edge of the run on."""

    size: int
    """Pixels a side of the field."""

    photon_counts: bool
    """Whether the values count photons."""

    noise: float
    """Standard deviation of a single value, rms over all values."""

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
        """Give the image values of some frames.

        Ramps in the place of a pair say one and the same of the image, its total light: together they count as one row. As many
        rows as there are ramps would make the problem that much worse conditioned.

        Where photons are counted, I_H+ and I_H- each get half the variance of their sum, smoothed over frames: if each count had
        its own variance, low counts would have too much weight.

        Args:
            scheme: scheme of the values.
            frame: ``(rows,)`` index of each frame.
            pairs: ``(rows, 2)`` Walsh rows of the frame's Hadamard pattern.
            values: ``(rows, patterns_per_frame)`` light, finite.
            variance: ``(rows, patterns_per_frame)`` variance of ``values``.
            time_s: ``(rows, patterns_per_frame)`` middle of each pattern after the first edge of the run.
            lamp: ``(rows,)`` brightness of the lamp over its mean.
            size: pixels a side of the field.
            photon_counts: whether the values count photons.

        Raises:
            InputError: the scheme has no image.
        """
        rows = image_rows_of(scheme)
        values, ramp = rows.as_pairs(values, frame), rows.is_ramp(frame)
        of_pair = variance[:, [rows.positive, rows.negative]]
        if photon_counts and len(values) >= _FEWEST_FRAMES:
            both = of_pair.sum(axis=1)
            of_pair = np.repeat(smooth(both, np.ones(len(both)), orders=(1,)).values[:, None] / 2, 2, axis=1)
        variance = variance.copy()
        variance[:, [rows.positive, rows.negative]] = of_pair
        floor = (_LEAST_NOISE * float(np.sqrt(np.mean(np.square(values))))) ** 2 + 1e-30
        variance = np.where(np.isfinite(variance), np.maximum(variance, floor), floor) / lamp[:, None] ** 2
        bright = values / lamp[:, None]
        fixed = fixed_columns(scheme)
        return cls(
            frame=frame,
            pairs=pairs,
            positive=bright[:, rows.positive],
            negative=bright[:, rows.negative],
            difference_variance=(variance[:, rows.positive] + variance[:, rows.negative])
            * np.where(ramp, max(1.0, float(ramp.sum())), 1.0),
            fixed=bright[:, fixed],
            fixed_variance=variance[:, fixed],
            time_s=time_s[:, [rows.positive, rows.negative, *fixed.tolist()]],
            size=size,
            photon_counts=photon_counts,
            noise=float(np.sqrt(np.mean(variance))),
        )

    def __len__(self) -> int:
        """Give the number of rows."""
        return len(self.frame)

    def times(self, factor: Floats) -> "ImageValues":
        """Multiply the light of each row, and its noise, by a factor, ``(rows,)``."""
        return replace(
            self,
            positive=self.positive * factor,
            negative=self.negative * factor,
            difference_variance=self.difference_variance * factor**2,
            fixed=self.fixed * factor[:, None],
            fixed_variance=self.fixed_variance * factor[:, None] ** 2,
        )

    @property
    def difference(self) -> Floats:
        """``(rows,)``: I_H = I_H+ - I_H-."""
        return self.positive - self.negative

    @property
    def difference_sigma(self) -> Floats:
        """``(rows,)``: standard deviation of ``difference``."""
        return np.sqrt(self.difference_variance)


def fixed_columns(scheme: Scheme) -> Integers:
    """Columns of the patterns that measure position, ascending. They are the same in every frame."""
    if scheme.position is None:
        return np.zeros(0, np.int64)
    return np.unique(scheme.position.columns).astype(np.int64)
