"""The light of a lamp that changes, brought to one moment of each frame."""

import numpy as np

from protocols import Floats, Mask


def to_one_moment(total: Floats, valid: Mask, time_s: Floats, light_weights: Floats) -> Floats:
    """Give factors that bring the patterns of each frame to the moment at which its total light was measured.

    The total light of a frame is known at the times of the patterns that make it, and between two frames it is taken to change
    evenly. At 100 Hz the light changes by a tenth of its ripple from one end of a frame to the other.

    Args:
        total: ``(frames,)`` total light, as free of noise as may be.
        valid: ``(frames,)`` whether it was measured.
        time_s: ``(frames, patterns_per_frame)`` middle of each pattern.
        light_weights: ``(patterns_per_frame,)`` weights of the patterns in the total.

    Returns:
        ``(frames, patterns_per_frame)``: total light of the frame over that at the time of the pattern; 1 where it is unknown.
    """
    weights = np.abs(light_weights)
    known = valid & (total > 0)
    if np.count_nonzero(known) < 2 or not weights.any():
        return np.ones_like(time_s)
    moment_s = time_s @ weights / weights.sum()
    at_patterns = np.interp(time_s, moment_s[known], total[known])
    own = np.where(known, total, 1.0)
    return np.where(known[:, None], own[:, None] / at_patterns, 1.0)
