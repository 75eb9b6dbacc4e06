"""Ramps in the first frames of a run, whose values are the absolute position of an object that Fourier patterns follow.

A frame that ends with a Hadamard pattern and its complement may end with a ramp and its complement instead. Their sum is that of
the all-on pattern all the same, so that the total light and the Fourier coefficients of the frame are what they are in any other,
and their difference is the position of the centroid,

    c = m (I - I') / (2 S) + (m - 1) / 2 px.

What an edge of a lit mirror loses is the same for a pattern and its complement, and drops out.

A binary ramp errs by some tenths of a pixel, by another amount at each place. Error diffusion also errs by up to a pixel on the
average of a whole column, at the borders of the field. The ramps here have exactly u or u + 1 lit samples in column u, in turn,
spread along the column as evenly as multiples of the golden ratio are, and moved by another such multiple in the next. Each
frame shows them moved on along the columns, so that what errors are left average out over the frames.

The light of the picture before that is left in a picture moves the centroid: an error d of its share by some m d / 2 px. In every
other pair of frames the complement comes first, so that what is left of that is 3 d / 2 of the distance from the field's middle.

References:
    Li, Cai, Wang, Yao, Zhao, "Single-pixel imaging of a translational object", Opt. Express (2023), discussion: "a few" moment
    patterns in front of a run, against the limit that phases give displacements and no positions.
    B. E. Bayer, Proc. IEEE Int. Conf. Communications (1973) 26-11: dithering by a matrix of thresholds.
    L. Kuipers, H. Niederreiter, "Uniform Distribution of Sequences", Wiley (1974), chapter 2: multiples of the golden ratio.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from protocols import Bytes, Floats, Integers, Mask

_GOLDEN: Final = (5**0.5 - 1) / 2
"""Multiples of the golden ratio, less whole numbers, are spread evenly over 0 to 1, however many there are."""


@dataclass(frozen=True)
class Ramps:
    """Ramps in the first frames, along x in even ones and along y in odd ones."""

    size: int
    """Pixels m a side of the field."""

    upsampling: int
    """Dithering samples a side of one pixel."""

    frames: int
    """Number of frames that show them."""

    positive: int
    """Column of H+, in whose place the ramp or its complement stands."""

    negative: int
    """Column of H-."""

    def axis(self, frame: Integers) -> Integers:
        """Give the axis along which each frame's ramp grows, 0 for x and 1 for y."""
        return np.asarray(frame % 2, np.int64)

    def falls(self, frame: Integers) -> Mask:
        """Give whether the complement comes first, so that the pattern in the place of H+ falls along its axis."""
        return np.asarray(frame // 4 % 2 == 1, np.bool_)

    def pattern(self, frame: int) -> Bytes:
        """Give the pattern of one frame in the place of H+, ``(samples, samples)`` of 0 and 1."""
        samples = self.size * self.upsampling
        along = np.arange(samples)
        rank = np.argsort(np.argsort(along * _GOLDEN % 1))
        of_axis = frame // 2
        moved = np.round(samples * _GOLDEN * (along * _GOLDEN + of_axis)).astype(np.int64)
        lit = rank[(along[:, None] + moved) % samples] < along + of_axis % 2
        ramp = lit if frame % 2 == 0 else lit.T
        return np.asarray(~ramp if frame // 4 % 2 else ramp, np.uint8)

    def patterns(self) -> Bytes:
        """Give all ramps, ``(frames, samples, samples)``, in play order."""
        return np.stack([self.pattern(frame) for frame in range(self.frames)])

    def centroid_px(self, frame: Integers, positive: Floats, negative: Floats, total: Floats) -> Floats:
        """Give the centroid along the axis of some frames from the values of both patterns and the total light, all ``(n,)``."""
        of_ramp = np.where(self.falls(frame), negative - positive, positive - negative)
        return np.asarray(self.size * of_ramp / (2 * total) + (self.size - 1) / 2, np.float64)
