"""Wild counts: single values that no motion and no lamp explains, found against the frames before and after.

The value of a position pattern changes little from frame to frame, and so does the sum of a pattern and its complement, the
total light. Each is compared with seven predictions from its neighbours in time: the lines through the two frames before and
the two after, the means of these, the means of the next and of the second ones to both sides, and the cubic through all four. A
value is wild where one of the means is off by far more than noise is, and none of the seven is near. Fast motion and jumps
leave one of them near, and so does a neighbour that is wild itself. What motion and bench do between frames counts as noise:
each prediction's errors are scaled by their own median over a block of frames.
"""

from typing import Final

import numpy as np

from protocols import Floats, Mask

_PREDICTIONS: Final = np.array(
    [
        [-1, 2, 0, 0],
        [0, 0, 2, -1],
        [0.5, 0.5, 0, 0],
        [0, 0, 0.5, 0.5],
        [0, 0.5, 0.5, 0],
        [0.5, 0, 0, 0.5],
        [-1 / 6, 2 / 3, 2 / 3, -1 / 6],
    ]
)
"""``(7, 4)``: weights of the frames at -2, -1, +1, +2: two lines, then five means."""

_LINES: Final = 2

_FAR: Final = 5.5
"""Standard deviations, of a mean of neighbours, beyond which a value may be wild."""

_NEAR: Final = 2.5
"""Standard deviations, of any prediction, within which it is not."""

_LOST_FAR: Final = 4.0
_LOST_NEAR: Final = 1.5
"""The same two for photon counts of exactly 0: where there is light, hardly any chance makes them."""

_LOST_SHARE: Final = 0.2
"""Share of the total light that must be missing then: the complement of the all-on pattern is dark by right."""

_LEAST_SHARE: Final = 0.1
"""Share of the total light below which no deviation is called wild: flaws of the bench's light are of that size."""

_SKEW: Final = 4.0
"""Counts that are added to the variance of few photons, which are far too many more often than a normal deviate is."""

_BLOCK: Final = 64
"""Frames in which the errors are taken to be alike."""

_MEDIAN: Final = 0.6745
"""Median of the absolute value of a normal deviate."""

_PASSES: Final = 8


def wild_counts(light: Floats, variance: Floats, pair: tuple[int, int] | None) -> Mask:
    """Find the values that do not go with their neighbours in time.

    Args:
        light: ``(frames, patterns_per_frame)``; NaN where it is not to be used.
        variance: ``(patterns_per_frame,)`` for noise that does not depend on the light; for photon counts all 0, and the variance
            is the light that is predicted.
        pair: columns of a pattern and its complement; None where there are none.

    Returns:
        ``(frames, patterns_per_frame)``: whether the value is wild. Where the sum of a pair is, the brighter of the two is
        taken if the sum is too high, the darker one if it is too low.
    """
    found = np.zeros(light.shape, bool)
    if len(light) < 3 or not np.isfinite(light).any():  # a line needs two neighbours
        return found
    series, noise = _smooth_series(light, variance, pair)
    known = series[:, -1] if pair is not None else 2 * series
    known = known[np.isfinite(known)]
    level = float(np.median(known)) if len(known) else 0.0
    left = series.copy()
    lost = _lost(light, pair) if not variance.any() else np.zeros(series.shape, bool)
    far, near = np.where(lost, _LOST_FAR, _FAR), np.where(lost, _LOST_NEAR, _NEAR)
    least = np.where(lost, _LOST_SHARE, _LEAST_SHARE) * level
    deviation = np.zeros_like(series)
    for _ in range(_PASSES):
        wild, off = _stand_out(left, noise, least, far, near)
        if not wild.any():
            break
        deviation[wild] = off[wild]
        left[wild] = np.nan
    if pair is None:
        return np.asarray(deviation != 0, bool)
    single = [k for k in range(light.shape[1]) if k not in pair]
    found[:, single] = deviation[:, :-1] != 0
    of_sum = np.flatnonzero(deviation[:, -1])
    first_brighter = light[of_sum, pair[0]] >= light[of_sum, pair[1]]
    too_high = deviation[of_sum, -1] > 0
    found[of_sum, np.where(first_brighter == too_high, pair[0], pair[1])] = True
    return found


def _smooth_series(light: Floats, variance: Floats, pair: tuple[int, int] | None) -> tuple[Floats, Floats]:
    """Series that change little from frame to frame: the single patterns, then the sum of the pair; and their variances."""
    if pair is None:
        return light, variance
    single = [k for k in range(light.shape[1]) if k not in pair]
    pairs = list(pair)
    series = np.column_stack([light[:, single], light[:, pairs].sum(axis=1)])
    return series, np.append(variance[single], variance[pairs].sum())


def _lost(light: Floats, pair: tuple[int, int] | None) -> Mask:
    """Whether a count is 0, or one of the pair, in the order of the series."""
    zero: Mask = np.asarray(light == 0, np.bool_)
    if pair is None:
        return zero
    single = [k for k in range(light.shape[1]) if k not in pair]
    return np.asarray(np.column_stack([zero[:, single], zero[:, list(pair)].any(axis=1)]), np.bool_)


def _stand_out(series: Floats, variance: Floats, least: Floats, far: Floats, near: Floats) -> tuple[Mask, Floats]:
    """Values that are the wildest of their neighbourhood, and by how much they are off."""
    padded = np.pad(series, ((2, 2), (0, 0)), constant_values=np.nan)
    count = len(series)
    neighbours = np.stack([padded[k : k + count] for k in (0, 1, 3, 4)])
    predicted = np.stack([_weighted(weights, neighbours) for weights in _PREDICTIONS])
    gain = 1 + (_PREDICTIONS**2).sum(axis=1)
    sigma = np.sqrt(gain[:, None, None] * (variance if variance.any() else np.maximum(predicted, 0.0) + _SKEW))
    off = series - predicted
    errors = np.abs(off) / np.maximum(sigma, 1e-300)
    errors = errors / np.maximum(_by_blocks(errors), 1.0)
    known = np.isfinite(errors)
    nearest = np.where(known, errors, np.inf).min(axis=0)
    nearest[~known.any(axis=0)] = 0.0
    farthest = np.where(known[_LINES:], errors[_LINES:], 0.0).max(axis=0)
    smallest = np.take_along_axis(off, np.where(known, np.abs(off), np.inf).argmin(axis=0)[None], axis=0)[0]
    candidate: Mask = (farthest > far) & (nearest > near) & (np.abs(smallest) > least)
    if series.shape[1] > 2:  # where most values of a frame are off together, it is the lamp, or a jump
        candidate &= 2 * np.count_nonzero(candidate, axis=1, keepdims=True) <= series.shape[1]
    around = np.pad(nearest, ((2, 2), (0, 0)))
    wildest = np.max([around[k : k + count] for k in range(5)], axis=0)
    return np.asarray(candidate & (nearest >= wildest), bool), smallest


def _weighted(weights: Floats, neighbours: Floats) -> Floats:
    """Sum of the neighbours that have a weight."""
    used = np.flatnonzero(weights)
    return np.asarray(np.tensordot(weights[used], neighbours[used], axes=1), np.float64)


def _by_blocks(errors: Floats) -> Floats:
    """Scale of the errors in each block of frames, that of the widest of the block and its two neighbours."""
    count = errors.shape[1]
    blocks = max(1, count // _BLOCK)
    edges = np.array([k * count // blocks for k in range(blocks + 1)], np.int64)
    medians = np.zeros((len(errors), blocks, errors.shape[2]))
    for k in range(blocks):
        part = np.sort(errors[:, edges[k] : edges[k + 1]], axis=1)  # NaN comes last
        half = np.isfinite(part).sum(axis=1, keepdims=True) // 2
        medians[:, k] = np.nan_to_num(np.take_along_axis(part, half.clip(max=part.shape[1] - 1), axis=1)[:, 0])
    widest = np.maximum(medians, np.maximum(np.roll(medians, 1, axis=1), np.roll(medians, -1, axis=1)))
    return np.repeat(widest / _MEDIAN, np.diff(edges), axis=1)
