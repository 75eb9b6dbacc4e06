"""Values that belong to other patterns than those at which they stand, put where they belong."""

from dataclasses import replace

import numpy as np

from instrument.measurement.light_model import IDEAL
from instrument.measurement.measurement import Measurement
from protocols import Floats, Mask


def by_patterns(measurement: Measurement, patterns: int) -> Measurement:
    """Move all values to patterns that are earlier by some number, later where it is negative.

    Args:
        measurement: of a run, before its light was found.
        patterns: by how many patterns the values come late.

    Returns:
        The measurement; frames at the end, or at the start, that lack a value are not valid.
    """
    return _moved(measurement, patterns, measurement.valid)


def after_lost_frame(measurement: Measurement, frame: int, first: int, last: int) -> Measurement:
    """Move the values from a frame on to the frame after each, and mask those between which the loss is not known to be.

    Args:
        measurement: of a run, before its light was found.
        frame: the frame that was lost.
        first: first frame that it may have been.
        last: last frame that it may have been.
    """
    moved = _moved(measurement, -measurement.values.shape[1], measurement.valid)
    number = np.arange(len(measurement))
    after, doubtful = number > frame, (number >= first) & (number <= max(last, frame))
    return replace(
        moved,
        arrived=np.where(after[:, None], moved.arrived, measurement.arrived),
        values=np.where(after[:, None], moved.values, measurement.values),
        variance=np.where(after[:, None], moved.variance, measurement.variance),
        valid=np.where(after, moved.valid, measurement.valid) & ~doubtful,
    )


def _moved(measurement: Measurement, patterns: int, valid: Mask) -> Measurement:
    """Move what was measured, as it arrived, and correct it anew by the light model that is known."""
    arrived = _earlier(np.where(valid[:, None], measurement.arrived, np.nan), patterns)
    variance = _earlier(measurement.variance, patterns)
    moved = replace(
        measurement,
        arrived=arrived,
        values=arrived,
        variance=np.where(np.isfinite(variance), variance, np.inf),
        valid=np.asarray(np.isfinite(arrived).all(axis=1), bool),
        light=IDEAL,
    )
    return moved.lit_by(measurement.light)


def _earlier(series: Floats, patterns: int) -> Floats:
    """``(frames, patterns_per_frame)`` in play order, each value some patterns earlier; NaN where nothing comes from."""
    moved = np.roll(series.ravel(), -patterns)
    if patterns > 0:
        moved[-patterns:] = np.nan
    elif patterns < 0:
        moved[:-patterns] = np.nan
    return np.asarray(moved.reshape(series.shape), np.float64)
