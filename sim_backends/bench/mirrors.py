"""Mirrors that need time: a picture begins with light of the one before."""

import numpy as np

from protocols import Floats


def remainder(transition_s: float, settling_s: float, picture_time_s: float) -> float:
    """Part c of the picture before that a value holds: (transition / 2 + settling / 4) / picture time, 1 at most.

    The light goes linearly from one picture to the next during the crossover, of which half is lost in the mean, and at most
    half of the picture. What is left of the way after it is closed in on exponentially with the time constant settling / 4, so
    that the mirrors stand within exp(-4), 2 %, at the end of the settling; such a lag takes its time constant from the picture.
    """
    return min(min(transition_s / picture_time_s, 1.0) / 2 + settling_s / (4 * picture_time_s), 1.0)


def lagged(light: Floats, part: float) -> Floats:
    """``(n,)`` light (1 - c) v_k + c v_(k-1) of pictures that would give ``light`` (n,); before the first all is dark."""
    if not part:
        return light
    before = np.concatenate([[0.0], light[:-1]])
    return light + (before - light) * part
