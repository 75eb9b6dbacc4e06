"""Levels: what the values of a pattern come to before and after each frame, by lines through a few frames to either side."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from instrument.numerics import compiled
from protocols import Floats, Integers

_LENGTHS: Final = np.array([30, 10, 4], np.int64)
"""Frames of a line: many where nothing changes near by, few beside another change."""

_FEWEST: Final = 3
"""Values from which on a line is fitted."""

_LONG: Final = 2
"""Lengths that are asked for jumps, the first ones."""

_BLOCK: Final = 256
"""Frames in which lines are taken to fit alike: far more than a change of the shift is near to."""

_THIRD: Final = 0.1855
"""What a third of the squares of normal deviates lie below: a third, as more than half may be near to a change in a short run."""

_MOST_CHI2: Final = 1000.0
"""Square at most of one level that jumps: so high that the highest place stays the place of the change in bright light."""


@dataclass(frozen=True, eq=False)
class Levels:
    """Lines through the frames that end with each one, and through those that begin with it."""

    before: Floats
    """``(lengths, frames, patterns_per_frame, 3)``: level half a frame after it, change a frame, and variance of the level."""

    after: Floats
    """Likewise, half a frame before it."""

    scale: Floats
    """``(lengths, frames, 1)``: factor that is in the variances, for what bends lines."""

    @classmethod
    def of(cls, light: Floats, sigma2: Floats, scale: Floats | None = None) -> "Levels":
        """Fit the lines.

        Args:
            light: ``(frames, patterns_per_frame)``; NaN where it is not known.
            sigma2: likewise, variance of each value.
            scale: how much larger squares are than noise makes them, as in ``scale``; found from the light if not given.
        """
        shape = (len(_LENGTHS), *light.shape, 3)
        before, after = np.full(shape, np.nan), np.full(shape, np.nan)
        _lines(np.ascontiguousarray(light), np.ascontiguousarray(sigma2), _LENGTHS, before, after)
        if scale is None:
            scale = _scale(before, after)
        before[..., 2] *= scale
        after[..., 2] *= scale
        return cls(before, after, scale)

    def jumps(self) -> Floats:
        """``(frames,)``: by how much the levels before a frame and from it on differ: sum of squares over their variances."""
        jumps = np.zeros(self.before.shape[1])
        for passed in (0, 1):  # as the shift may change within a frame
            one, two = self.before[:_LONG, : -1 - passed], self.after[:_LONG, 1 + passed :]
            step = two[..., 0] - one[..., 0] - 0.5 * passed * (one[..., 1] + two[..., 1])
            energy = step**2 / (one[..., 2] + two[..., 2])
            chi2 = np.minimum(np.nan_to_num(energy, nan=1.0), _MOST_CHI2).sum(axis=2).max(axis=0)
            jumps[1 + passed :] = np.maximum(jumps[1 + passed :], chi2)
        return jumps


def _scale(before: Floats, after: Floats) -> Floats:
    """How much larger squares are than noise makes them, ``(lengths, frames, 1)``, by what a third of them lie below.

    A lamp that flickers and motion that is not even bend lines, here as there.
    """
    energy = (after[:, 1:, :, 0] - before[:, :-1, :, 0]) ** 2 / (after[:, 1:, :, 2] + before[:, :-1, :, 2])
    frames = before.shape[1]
    blocks = max(1, frames // _BLOCK)
    edges = np.array([k * frames // blocks for k in range(blocks + 1)], np.int64)
    scale = np.ones((len(energy), blocks, 1))
    for k in range(blocks):
        part = np.sort(energy[:, edges[k] : edges[k + 1]], axis=1)  # NaN comes last
        third = np.isfinite(part).sum(axis=1, keepdims=True) // 3
        thirds = np.nan_to_num(np.take_along_axis(part, third.clip(max=part.shape[1] - 1), axis=1)[:, 0])
        scale[:, k, 0] = np.maximum(thirds.mean(axis=1) / _THIRD, 1.0)
    return np.repeat(scale, np.diff(edges), axis=1)


@compiled("void(f8[:,::1], f8[:,::1], i8[::1], f8[:,:,:,::1], f8[:,:,:,::1])")
def _lines(light: Floats, sigma2: Floats, lengths: Integers, before: Floats, after: Floats) -> None:
    """Fit all lines; what too few values are known of stays NaN. Where values lie off their line, its variance is larger."""
    frames, columns = light.shape
    sums = np.zeros((frames + 1, 7))
    for column in range(columns):
        origin = 0.0
        for frame in range(frames):  # sums of 1, x, x^2, y, x y, y^2 and the variance up to each frame
            y = light[frame, column]
            sums[frame + 1] = sums[frame]
            if np.isfinite(y):
                if sums[frame, 0] == 0:
                    origin = y
                y -= origin
                sums[frame + 1, 0] += 1
                sums[frame + 1, 1] += frame
                sums[frame + 1, 2] += frame * frame
                sums[frame + 1, 3] += y
                sums[frame + 1, 4] += frame * y
                sums[frame + 1, 5] += y * y
                sums[frame + 1, 6] += sigma2[frame, column]
        for w in range(len(lengths)):
            for frame in range(frames):
                for side in range(2):
                    low = frame if side else max(frame + 1 - lengths[w], 0)
                    high = min(frame + lengths[w], frames) if side else frame + 1
                    n = sums[high, 0] - sums[low, 0]
                    if n < _FEWEST:
                        continue
                    x = (sums[high, 1] - sums[low, 1]) / n
                    y = (sums[high, 3] - sums[low, 3]) / n
                    spread = sums[high, 2] - sums[low, 2] - n * x * x
                    slope = (sums[high, 4] - sums[low, 4] - n * x * y) / spread
                    rest = sums[high, 5] - sums[low, 5] - n * y * y - slope * slope * spread
                    each = (sums[high, 6] - sums[low, 6]) / n
                    each *= max(1.0, rest / (each * (n - 2)))
                    away = frame - x + (-0.5 if side else 0.5)
                    line = after if side else before
                    line[w, frame, column, 0] = origin + y + slope * away
                    line[w, frame, column, 1] = slope
                    line[w, frame, column, 2] = each * (1 / n + away * away / spread)
