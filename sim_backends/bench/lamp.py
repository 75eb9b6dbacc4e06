"""Light as it changes in time: the lamp's, and what comes past the modulator."""

import math
from dataclasses import dataclass

import numpy as np

from protocols import Floats


@dataclass(frozen=True)
class Lamp:
    """Brightness of the lamp that lights the object."""

    level: float = 1.0
    """At the first sync edge."""

    drift_per_s: float = 0.0
    """Relative change a second."""

    flicker: float = 0.0
    """Relative amplitude of a sine that begins at the first sync edge."""

    flicker_hz: float = 100.0
    """Frequency of the sine."""

    def brightness(self, time_s: Floats) -> Floats:
        """``(n,)``: brightness at ``time_s`` (n,) after the first sync edge, never below dark."""
        slow: Floats = self.level * np.maximum(1 + self.drift_per_s * time_s, 0.0)
        return slow * (1 + self.flicker * np.sin(2 * math.pi * self.flicker_hz * time_s)) if self.flicker else slow


@dataclass(frozen=True)
class Ambient:
    """Light that reaches the detector whatever the mirrors show: level (1 + ripple sin(2 pi f t)), t from the first sync edge."""

    level_per_s: float = 0.0
    """Mean light a second."""

    ripple: float = 0.0
    """Relative amplitude of its ripple."""

    ripple_hz: float = 100.0
    """Frequency of the ripple."""

    def light(self, begin_s: Floats, end_s: Floats) -> Floats:
        """``(n,)``: integral from ``begin_s`` to ``end_s``, both (n,)."""
        turn = 2 * math.pi * self.ripple_hz
        swing_s = self.ripple * (np.cos(turn * begin_s) - np.cos(turn * end_s)) / turn
        light: Floats = self.level_per_s * (end_s - begin_s + swing_s)
        return light
