"""How second-order moments become the angle of an object's principal axis."""

from dataclasses import dataclass

import numpy as np

from instrument.schemes.columns import Column
from protocols import Floats, Integers


@dataclass(frozen=True, eq=False)
class TurnReading:
    """The two patterns of ``patterns.saddle``, and what they see.

    With central moments mu of the object, in px^2 and over its light, its *elongation* is

        z = (mu20 - mu02) + 2 j mu11 = A exp(2 j angle),

    so that the angle of its long axis is 1/2 atan2(2 mu11, mu20 - mu02), and repeats after half a turn.
    """

    size: int
    """Pixels m a side of the field."""

    columns: Integers
    """``(2,)``: columns of the patterns of u^2 - v^2 and of u v."""

    after_middle_frames: Floats
    """``(2,)``: middle of each pattern against the middle of its frame, in frames."""

    @classmethod
    def of(cls, size: int, columns: tuple[Column, ...], squares: int, product: int) -> "TurnReading":
        """Read two columns of a frame."""
        after = np.array([columns[squares].after_middle_frames, columns[product].after_middle_frames])
        return cls(size, np.array([squares, product]), after)

    def elongation_px2(self, shares: Floats, squares_px: Floats, product_px: Floats) -> tuple[Floats, Floats]:
        """Give both parts of z.

        Args:
            shares: ``(frames, 2)`` values over the total light.
            squares_px: ``(frames, 2)`` position of the centroid, x and y, while the pattern of u^2 - v^2 was shown.
            product_px: likewise, while that of u v was.

        Returns:
            mu20 - mu02 and 2 mu11, ``(frames,)`` each.
        """
        about_middle = (shares - 0.5) * self.size**2 / 2
        u, v = (squares_px - (self.size - 1) / 2).T
        difference = about_middle[:, 0] - (u**2 - v**2)
        u, v = (product_px - (self.size - 1) / 2).T
        return difference, np.asarray(2 * (about_middle[:, 1] - u * v), np.float64)

    def part_variance_px4(self, share_variance: Floats) -> Floats:
        """``(frames, 2)``: variance of both parts of z by that of the shares, ``(frames, 2)``."""
        return np.asarray(share_variance * (np.array([1.0, 2.0]) * self.size**2 / 2) ** 2, np.float64)
