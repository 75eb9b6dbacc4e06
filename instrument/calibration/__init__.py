"""What a lab measures of its bench before it measures with it: real displacement, detector, mirrors, light, alignment.

Each measurement is a section of the calibration file (``instrument.config.Calibration``).
"""

from instrument.calibration.displacement import (
    FEWEST_POSITIONS,
    Ladder,
    Visit,
    displacement_of,
    static_plan,
    take_views,
)
from instrument.calibration.moving_run import displacement_of_run

__all__ = [
    "FEWEST_POSITIONS",
    "Ladder",
    "Visit",
    "displacement_of",
    "displacement_of_run",
    "static_plan",
    "take_views",
]
