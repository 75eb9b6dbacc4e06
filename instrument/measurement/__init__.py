"""The light model and the one ``Measurement`` that every estimator is given."""

from instrument.measurement.change_places import cheapest_place
from instrument.measurement.detector import Detector, light_of, noise_variance
from instrument.measurement.edge_light import bordering_share
from instrument.measurement.finding import Finding, FindingKind
from instrument.measurement.first_light import first_light
from instrument.measurement.image_values import ImageValues, fixed_columns
from instrument.measurement.light_model import IDEAL, LightModel, Parameter, Source
from instrument.measurement.light_stream import LightStream
from instrument.measurement.measurement import Measurement
from instrument.measurement.moved import after_lost_frame, by_patterns
from instrument.measurement.profile import Profile
from instrument.measurement.ripple import Ripple, ripples_seen
from instrument.measurement.screening import (
    Screened,
    screened,
    slips_of_counts,
    suspects_of_counts,
    usable_frames,
)
from instrument.measurement.slip_evidence import FEWEST_FRAMES
from instrument.measurement.slips import Change, Segment, Slips, in_step_again
from instrument.measurement.told import HIGHEST_VALUE, tell_slips
from instrument.measurement.wiring import Wiring, wiring_of

__all__ = [
    "FEWEST_FRAMES",
    "HIGHEST_VALUE",
    "IDEAL",
    "Change",
    "Detector",
    "Finding",
    "FindingKind",
    "ImageValues",
    "LightModel",
    "LightStream",
    "Measurement",
    "Parameter",
    "Profile",
    "Ripple",
    "Screened",
    "Segment",
    "Slips",
    "Source",
    "Wiring",
    "after_lost_frame",
    "bordering_share",
    "by_patterns",
    "cheapest_place",
    "first_light",
    "fixed_columns",
    "in_step_again",
    "light_of",
    "noise_variance",
    "ripples_seen",
    "screened",
    "slips_of_counts",
    "suspects_of_counts",
    "tell_slips",
    "usable_frames",
    "wiring_of",
]
