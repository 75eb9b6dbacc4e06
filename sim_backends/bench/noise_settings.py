"""The ``noise`` of ``[scene]``: how the light of a bin becomes what the counter reads."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from protocols.values import Frozen
from sim_backends.bench.bounds import DarkHertz, Level, Seed


class NoNoise(Frozen):
    """Exact values, for checks of the mathematics."""

    kind: Literal["none"] = "none"
    """Tells this table from the others."""


class PixelNoise(Frozen):
    """Gaussian noise on every pixel of the modulated scene: the convention behind the published tables."""

    kind: Literal["pixel"]
    """Tells this table from the others."""

    sigma: Level = 0.1
    """Standard deviation a pixel, on the scale of transmission 0 to 1: a value with n lit pixels gets sigma sqrt(n)."""

    seed: Seed = 0
    """Makes a run repeatable to the bit."""


class PhotonNoise(Frozen):
    """Photon counting: Poisson arrivals, dark counts, a dead time after each count, and afterpulses."""

    kind: Literal["poisson"]
    """Tells this table from the others."""

    peak_counts: Annotated[float, Field(gt=0, le=1e9)] = 250.0
    """Expected counts of an all-lit picture from the object alone, at the first picture, at ``light_level`` 1, before
    dead time and without what is lost at mirrors. A picture that lets half of the light through gives half of it."""

    peak_in_s: Annotated[float, Field(ge=1e-6, le=1e3)] | None = None
    """Picture time in which ``peak_counts`` are expected: a steady lamp gives ten times as many in a picture ten times as long.
    None: in one picture, however long it is."""

    dark_rate_hz: DarkHertz = 0.0
    """Dark counts a second. The data sheet of the -210 head is uncertain (50 or 600 a second): measure it."""

    dead_time_s: Annotated[float, Field(ge=0, lt=1e-3)] = 0.0
    """Dead time of head and counter together, after each count (20 ns reproduces the head's data sheet)."""

    dead_time_kind: Literal["non-paralyzable", "paralyzable"] = "non-paralyzable"
    """Whether a photon that comes in the dead time is lost and no more (n / (1 + n tau) counts a second at n photons a second),
    or prolongs it too (n exp(-n tau))."""

    afterpulse_probability: Annotated[float, Field(ge=0, le=0.5)] = 0.0
    """Probability that a count is followed by a false one (ions in the tube: some tenths of a percent to some percent)."""

    afterpulse_delay_s: Annotated[float, Field(gt=0, le=1e-3)] = 1e-6
    """Mean of the exponential delay of these: from some hundred nanoseconds to some microseconds."""

    seed: Seed = 0
    """Makes a run repeatable to the bit."""


Noise: TypeAlias = Annotated[NoNoise | PixelNoise | PhotonNoise, Field(discriminator="kind")]
"""Model of how the light of a bin becomes what the counter reads."""
