"""Light of the picture before: how much of it is in each picture, and how it is taken out."""

from typing import Final

import numpy as np

from instrument.measurement.light_model import Parameter
from instrument.schemes import Scheme
from protocols import Floats, Mask

_DIFFERENCE: Final = 3
"""Order of the differences over frames in which a moving object's own light no longer shows."""

_ALIKE: Final = 924 / 400
"""Factor on the variance of a slope between two such series, as neighbours in them are not independent: the sum of their squared
correlations, 1 + 2 (15^2 + 6^2 + 1) / 20^2."""

_FEWEST_FRAMES: Final = 64
"""Frames from which a leak can be told from chance."""

_SIGNIFICANT: Final = 3.5
"""Standard deviations of the slope above which a leak is believed: chance makes one in 4,000 runs. The slope is judged, not c,
which seems surer than it is where light is low: a slope of 0.6 +- 0.3, two standard deviations, is c = 0.27 +- 0.06, four."""

_MOST: Final = 0.4
"""A larger share is no leak, but a wrong order of the patterns."""


def without_leak(arrived: Floats, leak: float) -> Floats:
    """Solve y_k = (1 - c) v_k + c v_(k-1) for v, pattern by pattern; see ``LightModel``.

    Before the first pattern the field is dark. Where a pattern was not measured, the one after it is taken to have had the mean
    light of its column before it: that is in error by c times the difference only, and the next by c^2.

    Args:
        arrived: ``(frames, patterns_per_frame)`` light y in play order; NaN where none was measured.
        leak: c, below 1/2.

    Returns:
        The light v, of the same shape; NaN where none was measured.
    """
    if leak == 0:
        return arrived
    from scipy.signal import lfilter  # noqa: PLC0415 - slow to load: only what leaks needs it

    filled = without_gaps(arrived)
    solved = lfilter([1 / (1 - leak)], [1.0, leak / (1 - leak)], filled.ravel()).reshape(arrived.shape)
    return np.where(np.isfinite(arrived), solved, np.nan)


def without_gaps(values: Floats) -> Floats:
    """Give ``(frames, patterns_per_frame)`` values with the mean of its column in place of each that was not measured."""
    measured = np.isfinite(values)
    columns = np.where(measured, values, 0.0).sum(axis=0) / np.maximum(measured.sum(axis=0), 1)
    return np.where(measured, values, columns)


def leak_variance_ratio(leak: float) -> float:
    """Variance of a value after ``without_leak`` over that before, for noise that is the same in all patterns.

    The recursion v_k = (y_k - c v_(k-1)) / (1 - c) of white noise of variance 1 settles at 1 / ((1 - c)^2 - c^2).
    """
    return 1 / (1 - 2 * leak)


def difference_variance_ratio(leak: float) -> float:
    """Variance of the difference of two successive values over that of two independent ones, after ``without_leak``.

    A leak mixes the values of a pattern and its complement, and taking it out makes their noise opposite: in the recursion of
    ``leak_variance_ratio`` neighbours have the correlation -c / (1 - c), and the difference has 1 + c / (1 - c) = 1 / (1 - c) of
    the variance that two independent values give it.
    """
    return 1 / (1 - leak)


def leak_seen(values: Floats, variance: Floats, valid: Mask, scheme: Scheme) -> Parameter | None:
    """Estimate the leak from what the first pattern of each frame shares with the last one of the frame before.

    A frame ends with a pattern that changes from frame to frame, such as a Hadamard pattern's complement, and begins with one
    that is the same in all frames. What is fast in the light of the first is noise, but for its share c of the last. It shows as
    the slope of a regression of the one on the other, both as third differences over frames; the noise of the last, which
    flattens the slope, is taken off its power. As the last pattern follows its complement, what is fast in it is itself lessened
    by the leak, to 1 - 2 c: a slope s is c / (1 - 2 c). No image is needed for it, and a background does not disturb it.

    Args:
        values: ``(frames, patterns_per_frame)`` light as it arrived.
        variance: likewise, its variance.
        valid: ``(frames,)`` whether the frame was measured.
        scheme: what was shown.

    Returns:
        c with its standard deviation; None where the run does not show one.
    """
    last_changes = scheme.columns[-1].role == "hadamard" and scheme.columns[0].role != "hadamard"
    if not last_changes or np.count_nonzero(valid) < _FEWEST_FRAMES:
        return None
    first, before = values[1:, 0], values[:-1, -1]
    both = np.asarray(valid[1:] & valid[:-1], np.bool_)
    whole = np.convolve(~both, np.ones(_DIFFERENCE + 1), "valid") == 0
    fast_first = np.diff(np.where(both, first, 0.0), _DIFFERENCE)[whole]
    fast_before = np.diff(np.where(both, before, 0.0), _DIFFERENCE)[whole]
    of_noise = float(np.sum(np.diff(np.eye(_DIFFERENCE + 1), _DIFFERENCE, axis=0) ** 2))
    noise_power = (
        of_noise * float(np.sum(variance[:-1, -1][both])) * len(fast_before) / max(int(np.count_nonzero(both)), 1)
    )
    power = float(fast_before @ fast_before) - noise_power
    if power <= 0.1 * noise_power:
        return None
    slope = float(fast_first @ fast_before) / power
    left = fast_first - slope * fast_before
    slope_sigma = float(np.sqrt(_ALIKE * np.mean(left**2) * float(fast_before @ fast_before))) / power
    share, sigma = slope / (1 + 2 * slope), slope_sigma / (1 + 2 * slope) ** 2
    if not slope > _SIGNIFICANT * slope_sigma or share > _MOST:  # without noise, at rest, both are 0
        return None
    return Parameter(value=share, sigma=sigma, source="fitted")
