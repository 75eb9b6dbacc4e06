"""The ``[detector]`` section of a calibration file: dark counts, dead time and linear limit, and how the lamp flickers."""

import math
from typing import Annotated

from pydantic import Field

from instrument.config.calibration_section import Section
from instrument.config.light_table import DeadTimeKind
from protocols import Frozen


class Measured(Frozen):
    """A number and its standard deviation."""

    value: float
    """The number."""

    sigma: Annotated[float, Field(ge=0)]
    """Its standard deviation."""

    def __str__(self) -> str:
        """Give both as a person writes them: to the second figure of the standard deviation."""
        if not 1e-9 < self.sigma < 1e9:
            return f"{self.value:.6g} +- {self.sigma:.2g}"
        places = 1 - math.floor(math.log10(self.sigma))
        value, sigma = round(self.value, places) + 0.0, round(self.sigma, places)
        return f"{value:,.{max(0, places)}f} +- {sigma:,.{max(0, places)}f}"


class LampLine(Frozen):
    """A line in the spectrum of the light."""

    frequency_hz: Annotated[float, Field(ge=0)]
    """Its frequency."""

    amplitude: Annotated[float, Field(ge=0)]
    """Its amplitude over the mean light."""

    name: str = ""
    """What makes it, in words."""


class DetectorSection(Section):
    """What the detector does to light."""

    dark_rate_hz: Measured
    """Counts a second of a black picture."""

    shutter_closed: bool = False
    """Whether the shutter was closed meanwhile: if not, stray light is among the dark counts."""

    dead_time_s: Measured | None = None
    """Dead time of detector and counter together; None where only the dark counts were measured."""

    dead_time_kind: DeadTimeKind | None = None
    """Its kind; None where the light was too dim, or the time too short, to tell."""

    chi_square_between: float | None = None
    """By how much chi-square the other kind fits worse."""

    linear_limit_hz: Annotated[float, Field(gt=0)] | None = None
    """Counts a second at which a tenth of the photons is not counted."""

    brightest_hz: Annotated[float, Field(ge=0)] | None = None
    """Counts a second of the white picture, meanwhile."""

    flicker: tuple[LampLine, ...] = ()
    """Lines in the spectrum of the light, the strongest first."""
