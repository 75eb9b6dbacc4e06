"""The ``[scene]`` table of bench.toml."""

from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from protocols.values import Frozen
from sim_backends.bench.bounds import Angle, Factor, Instant, Level, Part, PlaceMm, PlacePx
from sim_backends.bench.fault_settings import Fault
from sim_backends.bench.noise_settings import Noise, NoNoise
from sim_backends.bench.realism import flaws

_MOST_PATTERNS: Final = 1_000_000


class SwappedPatterns(Frozen):
    """Two patterns of each frame that stand in each other's place in the modulator's memory."""

    patterns_per_frame: Annotated[int, Field(ge=2, le=_MOST_PATTERNS)] = 6
    """Patterns of a frame."""

    first: Annotated[int, Field(ge=0, lt=_MOST_PATTERNS)] = 4
    """Place of the one in the frame, from 0. In the six-pattern scheme the Hadamard pattern is at 4."""

    second: Annotated[int, Field(ge=0, lt=_MOST_PATTERNS)] = 5
    """Place of the other, from 0. In the six-pattern scheme the complement is at 5."""

    @model_validator(mode="after")
    def _inside(self) -> Self:
        if max(self.first, self.second) >= self.patterns_per_frame:
            msg = f"a frame of {self.patterns_per_frame} patterns has the places 0 to {self.patterns_per_frame - 1}"
            raise ValueError(msg)
        return self


class SceneSettings(Frozen):
    """What stands before the modulator, how it moves, and what spoils the measurement."""

    realism: Literal["ideal", "realistic"] = "ideal"
    """``realistic`` takes the flaws of a real bench (``realism.py``) where this table does not say otherwise."""

    object: str = "letter-B"
    """A built-in name, or a path relative to bench.toml: PNG (grey 0 to white) or NPY (transmission 0 to 1)."""

    object_height_px: Annotated[float, Field(gt=0, le=4096)] | None = None
    """Height of the object where it is not displaced. None: for a built-in 36 px in a 128 px image, in proportion
    otherwise; for a file the longer side of the picture fills the image."""

    object_level: Annotated[float, Field(ge=0, le=1)] = 1.0
    """A factor on the object's transmission. 0 takes it out of the light, but not out of what ``peak_counts`` is measured on: for
    recording a background alone, by the same lamp."""

    object_growth: Annotated[float, Field(gt=-1, le=10)] = 0.0
    """Relative growth of the object's image about its centre from the first sync edge to the end of the run, linear in time.
    It stays as bright, so that its light grows with its area."""

    object_turn_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """Turn of the object's image about its centre in the same time, linear in time; a positive angle is clockwise as one
    looks at the picture."""

    blur_px: Annotated[float, Field(ge=0, le=100)] = 0.0
    """Blur of the image on the modulator, object and background: standard deviation of a Gaussian, in image pixels."""

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

    led_flicker: Part = 0.0
    """Relative amplitude of the lamp's flicker at twice ``mains_hz``: a sine that begins at the first sync edge."""

    mains_hz: Annotated[float, Field(gt=0, le=1e6)] = 50.0
    """Frequency of the mains. Lamps flicker at twice as much: 100 Hz."""

    illumination_falloff: Part = 0.0
    """Part of the light that is missing in the corners of the field: the illumination is 1 - falloff (r / corner)^2 at the
    distance r from the middle. It is fixed to the modulator's field, and the object moves through it."""

    ambient_level: Level = 0.0
    """Light that reaches the detector past the modulator, whatever the pattern: a part of what the object gives in an
    all-lit picture (as ``peak_counts`` measures it). Neither ``light_level`` nor ``object_level`` changes it."""

    ambient_ripple: Part = 0.0
    """Relative amplitude of the ambient light's ripple at twice ``mains_hz``: a sine that begins at the first sync edge."""

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
    """Crossover: time over which the light goes linearly from one picture to the next (about 4 us on the real mirrors). A
    value holds the part transition / (2 picture time) of the picture before."""

    mirror_settling_s: Instant = 0.0
    """Time after the crossover until the mirrors stand (about 8.5 us on the real ones): the rest of the way is closed in on
    exponentially, with a quarter of this time as its time constant. It adds settling / (4 picture time) to that part."""

    mirrors_inverted: bool = False
    """The detector sees the mirrors that are off: wired, or placed, on the wrong side."""

    swap: SwappedPatterns | None = None
    """Two patterns of each frame that are shown in each other's place."""

    patterns_late: Annotated[int, Field(ge=-1000, le=1000)] = 0
    """Number of picture times by which all patterns come late, against their edges; early where negative. The guard
    picture's pattern fills the gap."""

    sync_jitter_s: Instant = 0.0
    """Standard deviation of each sync edge."""

    noise: Noise = NoNoise()
    """Model of how light becomes what the counter reads."""

    fresh_noise: bool = False
    """Whether every run on this bench has noise of its own, which follows from the seed and from how many runs there were
    before. Otherwise two runs of the same plan are alike to the bit, and their mean is no better than one."""

    spike_probability: Part = 0.0
    """Probability that a bin is read far too high: a cosmic particle, or pick-up in a cable."""

    spike_factor: Factor = 10.0
    """What is read there instead of 1, in terms of the bin's own value."""

    faults: Annotated[tuple[Fault, ...], Field(max_length=1000)] = ()
    """Faults of every run."""

    realtime: bool = False
    """Let simulated time pass as real time does."""

    @model_validator(mode="after")
    def _with_flaws(self) -> Self:
        if self.realism == "realistic":
            for key, value in flaws({key: getattr(self, key) for key in self.model_fields_set}).items():
                object.__setattr__(self, key, value)  # a frozen model, which nobody has seen yet
        return self
