"""Opposites: which two successive values of a frame go up and down against each other, as a pattern and its complement do.

A pattern and its complement add to the total light, so that what the one lacks the other has. Values of position patterns, which
are the same in all frames, only have their noise, and each its own. Deviations from the frames beside, over their own scale, are
so correlated by some rho < 0 for the two that are a pair, and not for any other two. Minus twice the log-likelihood ratio of a
correlated and an uncorrelated pair of normal deviates a, b is

    log(1 - rho^2) + (rho^2 (a^2 + b^2) - 2 rho a b) / (1 - rho^2),

on average below 0 for the pair and above 0 for others, whatever the noise of each pattern is. Nothing is assumed of it: a leak, a
lamp or a vibration enlarges a scale, and tells nothing.
"""

from typing import Final

import numpy as np

from protocols import Floats, Integers, Mask

_BLOCK: Final = 64
"""Frames in which noise and motion are taken to be alike."""

_MEDIAN: Final = 0.6745
"""Median of the absolute value of a normal deviate."""

_LEAST: Final = 0.25
"""Variance at least, over that of photons or of the detector."""

_EVEN: Final = 0.01
"""Standard deviation at least, over the value: no light of a bench is more even than that."""

_WINDOWS: Final = (31, 255, 1023)
"""Frames over which products are averaged: the first patterns are strong and few, the last weak and many."""

_ALIKE: Final = 0.4
"""Share of a deviation that is left at most of its sum with one to the other side."""

_AROUND: Final = 3
"""Frames to both sides from whose mean a value deviates."""

_WIDE: Final = 1.3
"""Variance of a mean of products of such deviations, over that of independent ones: 1 + 2 sum rho_k^2 of their correlations."""

_SIGMAS: Final = 1.6
"""Standard deviations that are taken off a correlation: the most opposite of seven are not opposite in noise."""

_MOST: Final = 30.0
"""Cost at most of one frame."""

_STRONGEST: Final = 0.9
"""Correlation at most: strong pairs are opposites to the accuracy of their scales."""

_LIKEST: Final = 0.999
"""Correlation at most before chance is taken off: of a few frames all may be 1."""

_CLIPPED: Final = 3.0
"""Deviation at most that counts for a correlation: the first patterns are far stronger than those they are averaged with."""


def noise_of(light: Floats, variance: Floats) -> Floats:
    """Variance of each value, as its deviations from the frames beside show it.

    Args:
        light: ``(frames, patterns_per_frame)``; NaN where no value was measured.
        variance: ``(patterns_per_frame,)`` for noise that does not depend on the light; for photon counts all 0.

    Returns:
        ``(frames, patterns_per_frame)``: above 0 everywhere.
    """
    off = np.abs(deviations(light))
    frames = len(light)
    blocks = max(1, frames // _BLOCK)
    edges = np.array([k * frames // blocks for k in range(blocks + 1)], np.int64)
    scales, levels = np.empty((2, blocks, light.shape[1]))
    for k in range(blocks):
        part = slice(edges[k], edges[k + 1])
        scales[k], levels[k] = _medians(off[part]), _medians(light[part])
    seen = (scales / _MEDIAN) ** 2
    modelled = np.maximum(_LEAST * (variance if variance.any() else np.maximum(levels, 1.0)), (_EVEN * levels) ** 2)
    return np.asarray(np.repeat(np.maximum(np.maximum(seen, modelled), 1e-280), np.diff(edges), axis=0), np.float64)


def deviations(light: Floats) -> Floats:
    """Deviation of each value from the mean of those of the frames around that are known, with the variance of a value."""
    known = np.isfinite(light)
    total = np.cumsum(np.pad(np.where(known, light, 0.0), ((1, 0), (0, 0))), axis=0)
    number = np.cumsum(np.pad(known, ((1, 0), (0, 0))), axis=0, dtype=np.float64)
    index = np.arange(len(light))
    low, high = np.maximum(index - _AROUND, 0), np.minimum(index + _AROUND + 1, len(light))
    count = number[high] - number[low] - 1  # its own is none of them
    mean = (total[high] - total[low] - light) / np.maximum(count, 1.0)
    return np.asarray(np.where(count > 0, (light - mean) / np.sqrt(1 + 1 / np.maximum(count, 1.0)), np.nan), np.float64)


def opposed(light: Floats) -> Mask:
    """``(frames, patterns_per_frame)``: whether one of the two values beside deviates as far to the other side."""
    off = deviations(light).ravel()
    beside = np.pad(off, 1, constant_values=np.nan)
    nearest = np.fmin(np.abs(off + beside[:-2]), np.abs(off + beside[2:]))
    return np.asarray((nearest < _ALIKE * np.abs(off)).reshape(light.shape), bool)


def opposites(light: Floats, sigma2: Floats, first: int, most: int) -> tuple[Floats, bool]:
    """Give what each shift costs in each frame.

    Args:
        light: ``(frames, patterns_per_frame)`` in play order; NaN where no value was measured.
        sigma2: likewise, variance of each value.
        first: column of a pattern whose complement follows it.
        most: patterns at most by which values come late or early.

    Returns:
        ``(frames, 2 most + 1)`` costs; and whether any two values are opposites, so that the costs say something.
    """
    frames, per_frame = light.shape
    sigma = np.sqrt(sigma2)
    lamp = _lamp(deviations(light) / sigma)[:, None] * sigma
    starts: Integers = per_frame * np.arange(1, frames + 1, dtype=np.int64) + first
    place: Integers = np.add.outer(starts, np.arange(-most, most + 1, dtype=np.int64))
    room = np.full(per_frame, np.nan)  # nothing is known of bins before the first frame and after the last one
    light, lamp, sigma = (np.concatenate([room, part.ravel(), room]) for part in (light, lamp, sigma))
    either = light[place] + light[place + 1]  # of both, or of none
    one, two = (
        (deviations(np.where(np.isfinite(either), light[at], np.nan)) - lamp[at]) / sigma[at]
        for at in (place, place + 1)
    )
    rho = -_strength(one, two)[:, None]
    left = 1 - rho**2
    cost = np.log(left) + (rho**2 * (one**2 + two**2) - 2 * rho * one * two) / left
    return np.asarray(np.clip(np.nan_to_num(cost), -_MOST, _MOST) / _WIDE, np.float64), bool(rho.any())


def _lamp(scaled: Floats) -> Floats:
    """``(frames,)``: what all values of a frame have in common, as far as they have anything.

    With it the last value of a frame and the first of the next are opposites under a lamp that flickers: a bright frame
    makes those beside it dark, as deviations from their neighbours. The mean pairwise product is the power p of what m values
    have in common, beside noise of the power 1 - p, and m p / (m p + 1 - p) of their mean is it (Wiener 1949).
    """
    filled = np.nan_to_num(scaled)
    m = scaled.shape[1]
    total = filled.sum(axis=1)
    power = _means((total**2 - (filled**2).sum(axis=1)) / (m * (m - 1)))
    power = np.clip(power - _SIGMAS * np.sqrt(_WIDE / (m * (m - 1) / 2 * _BLOCK)), 0.0, 1.0)
    return np.asarray(power * total / (m * power + 1 - power), np.float64)


def _means(values: Floats) -> Floats:
    """``(frames,)``: means over a block of frames around each."""
    half, frames = _BLOCK // 2, len(values)
    total = np.concatenate([np.zeros(1), np.cumsum(values)])
    low, high = np.maximum(np.arange(frames) - half, 0), np.minimum(np.arange(frames) + half + 1, frames)
    return np.asarray((total[high] - total[low]) / (high - low), np.float64)


def _strength(one: Floats, two: Floats) -> Floats:
    """``(frames,)``: how strongly the most opposite two values around a frame are correlated, less what chance makes.

    The inverse hyperbolic tangent of a correlation coefficient of n deviates has the variance 1 / (n - 3) (Fisher 1915).
    """
    frames = len(one)
    known = np.isfinite(one) & np.isfinite(two)
    one, two = (np.clip(np.where(known, part, 0.0), -_CLIPPED, _CLIPPED) for part in (one, two))
    total = np.cumsum(np.pad(np.stack([one * two, one * one, two * two, known]), ((0, 0), (1, 0), (0, 0))), axis=1)
    strength = np.zeros(frames)
    for window in _WINDOWS:
        half = min(window, frames) // 2
        low = np.maximum(np.arange(frames) - half, 0)
        high = np.minimum(np.arange(frames) + half + 1, frames)
        both, first, second, count = total[:, high] - total[:, low]
        least = np.maximum(count, 1.0) / 2  # what is far below its noise is correlated with nothing
        correlation = -both / np.sqrt(np.maximum(first, least) * np.maximum(second, least))
        z = np.arctanh(np.clip(correlation, 0.0, _LIKEST)) - _SIGMAS * np.sqrt(_WIDE / np.maximum(count - 3, 1))
        strength = np.maximum(strength, z.max(axis=1))
    return np.asarray(np.minimum(np.tanh(strength), _STRONGEST), np.float64)


def _medians(values: Floats) -> Floats:
    """Median over frames of the values that are numbers; 0 where there is none."""
    part = np.sort(values, axis=0)  # NaN comes last
    half = np.isfinite(part).sum(axis=0, keepdims=True) // 2
    return np.asarray(np.nan_to_num(np.take_along_axis(part, half.clip(max=len(part) - 1), axis=0)[0]), np.float64)
