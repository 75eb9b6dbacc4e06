"""What a lab measures of its bench before it measures with it: real displacement, detector, mirrors, light, alignment.

Each measurement is a section of the calibration file (``instrument.config.Calibration``).
"""

from instrument.calibration.alignment import (
    AlignmentResult,
    calibrate_alignment,
    still_image,
    target_letter,
    verdict_of,
)
from instrument.calibration.dead_time import DeadTimeFit, LightLadder, better, counted_hz, fit_dead_time
from instrument.calibration.detector import DetectorResult, calibrate_detector, linear_limit_hz, name_of_line
from instrument.calibration.displacement import (
    FEWEST_POSITIONS,
    Ladder,
    Visit,
    displacement_of,
    static_plan,
    take_views,
)
from instrument.calibration.many_runs import displacement_of_runs
from instrument.calibration.mirrors import MirrorsResult, calibrate_mirrors, response
from instrument.calibration.moving_run import displacement_of_run
from instrument.calibration.orientation import (
    Match,
    laid,
    match_target,
    place_of,
    upright,
)
from instrument.calibration.pictures import PictureCounts, PictureField, counts_of, together
from instrument.calibration.pooled import pooled
from instrument.calibration.profile import ProfileResult, calibrate_light, falloff_of

__all__ = [
    "FEWEST_POSITIONS",
    "AlignmentResult",
    "DeadTimeFit",
    "DetectorResult",
    "Ladder",
    "LightLadder",
    "Match",
    "MirrorsResult",
    "PictureCounts",
    "PictureField",
    "ProfileResult",
    "Visit",
    "better",
    "calibrate_alignment",
    "calibrate_detector",
    "calibrate_light",
    "calibrate_mirrors",
    "counted_hz",
    "counts_of",
    "displacement_of",
    "displacement_of_run",
    "displacement_of_runs",
    "falloff_of",
    "fit_dead_time",
    "laid",
    "linear_limit_hz",
    "match_target",
    "name_of_line",
    "place_of",
    "pooled",
    "response",
    "static_plan",
    "still_image",
    "take_views",
    "target_letter",
    "together",
    "upright",
    "verdict_of",
]
