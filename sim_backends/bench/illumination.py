"""How the lamp lights the modulator's field."""

import numpy as np

from protocols import Floats


def illumination(samples: int, falloff: float) -> Floats:
    """``(samples, samples)``: 1 in the middle of the field, 1 - ``falloff`` in its corners, by the distance squared.

    The profile stands still in the field of the modulator, whatever the object does. An uneven lamp that stands still before a
    moving object, the darkening of a lens towards its border and uneven collection behind the modulator all look like this.
    """
    across = ((np.arange(samples) + 0.5) / samples - 0.5) ** 2
    profile: Floats = 1 - falloff * (across[:, None] + across[None, :]) / 0.5
    return profile
