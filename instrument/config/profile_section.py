"""The ``[light]`` section of a calibration file: where the light is, and how much of it comes whatever the picture is."""

from typing import Annotated

from pydantic import Field

from instrument.config.calibration_section import Section
from instrument.config.detector_section import Measured


class ProfileSection(Section):
    """Illumination of the field in blocks, and the light of a black picture."""

    field_mirrors: Annotated[int, Field(gt=0)]
    """Mirrors a side of the field, in the middle of the modulator, that the blocks divide."""

    profile: tuple[tuple[float, ...], ...]
    """Light of each block over the mean of all; rows from top to bottom, columns from left to right."""

    profile_sigma: tuple[tuple[float, ...], ...]
    """Standard deviation of each."""

    falloff: Measured
    """Part a of the light that is missing in the corners, by the fit 1 - a (r / corner)^2."""

    white_hz: Annotated[float, Field(ge=0)]
    """Photons a second of the white picture, the black one taken off."""

    background_hz: Measured
    """Photons and dark counts a second of a black picture."""
