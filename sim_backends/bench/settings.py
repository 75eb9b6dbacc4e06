"""The ``[scene]`` table of bench.toml."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from protocols.values import Frozen
from sim_backends.bench.bounds import (
    Angle,
    DarkHertz,
    Factor,
    Index,
    Instant,
    LaidOut,
    Level,
    PlaceMm,
    PlacePx,
    Seed,
)


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
    """Photon counting: Poisson arrivals, dark counts, and a dead time after each count."""

    kind: Literal["poisson"]
    """Tells this table from the others."""

    peak_counts: Annotated[float, Field(gt=0, le=1e9)] = 250.0
    """Expected counts of an all-lit picture from the object alone, at the first picture, at ``light_level`` 1 and
    before dead time. A picture that lets half of the light through gives half of it."""

    dark_rate_hz: DarkHertz = 0.0
    """Dark counts a second. The data sheet of the -210 head is uncertain (50 or 600 a second): measure it."""

    dead_time_s: Annotated[float, Field(ge=0, lt=1e-3)] = 0.0
    """Non-paralyzable dead time of head and counter together (20 ns reproduces the head's data sheet)."""

    seed: Seed = 0
    """Makes a run repeatable to the bit."""


Noise: TypeAlias = Annotated[NoNoise | PixelNoise | PhotonNoise, Field(discriminator="kind")]
"""Model of how the light of a bin becomes what the counter reads."""


class DroppedEdge(Frozen):
    """The counter misses the edge that opens a picture, so one bin holds two pictures."""

    kind: Literal["drop-edge"]
    """Tells this table from the others."""

    picture: Index
    """Index of the picture, from 0."""


class DoubledEdge(Frozen):
    """A bouncing line: the counter sees a second edge soon after the one that opens a picture."""

    kind: Literal["double-edge"]
    """Tells this table from the others."""

    picture: Index
    """Index of the picture, from 0."""

    after_s: Annotated[float, Field(gt=0, le=10)] = 2e-6
    """Time from the edge to its echo, in seconds."""


class Stall(Frozen):
    """The modulator stays on a picture for ever: no later edge, and it never says that it has finished."""

    kind: Literal["stall"]
    """Tells this table from the others."""

    picture: Index
    """The last picture that is shown, from 0."""


class SurplusEdges(Frozen):
    """Edges that go on, one a picture time, after the guard picture."""

    kind: Literal["surplus-edges"]
    """Tells this table from the others."""

    edges: LaidOut = 1
    """Number of edges."""


Fault: TypeAlias = Annotated[DroppedEdge | DoubledEdge | Stall | SurplusEdges, Field(discriminator="kind")]
"""Something that goes wrong in every run on this bench."""


class SceneSettings(Frozen):
    """What stands before the modulator, how it moves, and what spoils the measurement."""

    object: str = "letter-B"
    """A built-in name, or a path relative to bench.toml: PNG (grey 0 to white) or NPY (transmission 0 to 1)."""

    object_height_px: Annotated[float, Field(gt=0, le=4096)] | None = None
    """Height of the object where it is not displaced. None: for a built-in 36 px in a 128 px image, in proportion
    otherwise; for a file the longer side of the picture fills the image."""

    object_level: Annotated[float, Field(ge=0, le=1)] = 1.0
    """A factor on the object's transmission. 0 takes it out of the light, but not out of what ``peak_counts`` is measured on: for
    recording a background alone, by the same lamp."""

    start_px: tuple[PlacePx, PlacePx] | None = None
    """Column and row of the object's centre where it is not displaced. None: for a built-in a quarter of the image from
    the upper left corner, from where the standard motion takes it along the diagonal to three quarters; for a file the
    middle of the image."""

    trajectory: str | None = None
    """Path of a CSV ``t_s,x_px,y_px`` that replaces the stage's motion; t = 0 is the run's first sync edge."""

    object_at_mm: PlaceMm | None = None
    """Stage position at which the object is not displaced; None: where the first run on this bench finds the stage."""

    px_per_mm: Factor | None = None
    """Image pixels a millimetre of stage travel; None: 7.2 in a 128 px image, in proportion otherwise."""

    axis_angle_deg: Angle = 45.0
    """Direction of positive stage travel in the image: 0 is along x (right), 90 along y (down), so a positive angle
    turns clockwise as one looks at the picture."""

    light_level: Factor = 1.0
    """Brightness of the lamp: a factor on all light."""

    led_drift_per_s: Annotated[float, Field(ge=-1e6, le=1e6)] = 0.0
    """Relative change of the lamp's brightness a second, counted from the first sync edge (it never falls below dark)."""

    background: str | None = None
    """A built-in name or a path, as ``object``: what stands still beside the object."""

    background_px: tuple[PlacePx, PlacePx] | None = None
    """Column and row of the background's centre. None: for a built-in the upper right quarter, beside the diagonal; for
    a file the middle of the image, which it fills."""

    background_level: Level = 1.0
    """A factor on the background's transmission."""

    edge_loss: Annotated[float, Field(ge=0, le=0.25)] = 0.0
    """Part of a lit mirror's light that is lost for each of its four sides that borders a dark mirror. The same for
    a pattern and its complement on an even scene, so that it stays out of their difference but not of their sum."""

    mirror_transition_s: Instant = 0.0
    """Time over which the light goes linearly from one picture to the next (about 4 us on the real mirrors)."""

    sync_jitter_s: Instant = 0.0
    """Standard deviation of each sync edge."""

    noise: Noise = NoNoise()
    """Model of how light becomes what the counter reads."""

    faults: Annotated[tuple[Fault, ...], Field(max_length=1000)] = ()
    """Faults of every run."""

    realtime: bool = False
    """Let simulated time pass as real time does."""
