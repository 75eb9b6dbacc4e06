"""The acquisition as a frozen value: compare it, store it, check it, run it."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, PlainValidator, SerializeAsAny, field_validator, model_validator

from instrument.config import (
    DEFAULT_SCHEME,
    ConfigError,
    RunTable,
    SchemeSettings,
    StopTable,
    read_document,
    scheme_problems,
    settings_of,
    validate_table,
)
from instrument.shown import card
from protocols import Frozen, InputError, MotionProfile, PixelGrid
from protocols.plain_file import path_of

_ONCE_OF_THE_PLAN = ("upsampling", "fourier_cycles", "hadamard_order", "shuffle_seed")
"""Keys that stood beside ``scheme`` in recordings of version 0.1."""

ABOUT_THE_RUN: Final = frozenset({"run", "stop_if"})
"""Tables that say nothing of what is shown: with others of them, plans have the same patterns."""

MOST_PATTERNS: Final = 100_000_000
"""Patterns of a run at most: 2 GB of counts and values, and a hundred times what known boards play."""

MOST_PATTERN_GB: Final = 8.0
"""Room for unique patterns: twice the memory of the boards that are known."""

MOST_DAYS: Final = 7
"""Length of a run, ramps included."""

SLOWEST_MM_S: Final = 1e-6
"""A stage that is slower than this stands still."""


class _Numbers(Frozen):
    """A table without switches, so that ``true`` in the place of a number is a mistake and not a 1."""

    @field_validator("*", mode="before")
    @classmethod
    def _no_bool(cls, value: object) -> object:
        if isinstance(value, bool):
            raise ValueError(f"is {str(value).lower()}, which is no number")  # noqa: TRY004 - pydantic collects these
        return value


def _is_none(value: object) -> bool:
    """Whether a table is missing: recordings of plans without it stay as programs of before know them."""
    return value is None


class MotionPlan(_Numbers):
    """How the stage carries the object during a run."""

    start_mm: Annotated[float, Field(ge=-1e6, le=1e6)] = 0.0
    """Where the stage stands before the run. The run-up starts here."""

    velocity_mm_s: Annotated[float, Field(ge=-1e6, le=1e6)]
    """Cruise velocity; its sign is the direction."""

    acceleration_mm_s2: Annotated[float, Field(gt=0, le=1e9)] = 50.0
    """Acceleration of the run-up and of the run-down."""

    acquire: Literal["cruise", "from-rest"] = "cruise"
    """``cruise``: the first pattern is shown when the run-up is over. ``from-rest``: when the stage starts to move."""

    settle_s: Annotated[float, Field(ge=0, le=3600)] = 0.1
    """``cruise`` only: time of cruise before the first pattern and after the last, as the controllers respond late."""

    field: Literal["stay", "may-leave"] = "stay"
    """``stay``: a plan in which the object certainly leaves the field is refused. ``may-leave``: it is carried out all the same,
    with a warning; the frames in which the object is inside are as good as ever."""

    @field_validator("velocity_mm_s")
    @classmethod
    def _moves(cls, velocity_mm_s: float) -> float:
        if velocity_mm_s == 0:
            raise ValueError("is 0: leave out the whole [motion] table for an object at rest")
        if abs(velocity_mm_s) < SLOWEST_MM_S:
            raise ValueError(f"is {velocity_mm_s:g}: at least {SLOWEST_MM_S:g}, a millimetre in 11 days")
        return velocity_mm_s

    @property
    def profile(self) -> MotionProfile:
        """Velocity and acceleration without direction."""
        return MotionProfile(velocity_mm_s=abs(self.velocity_mm_s), acceleration_mm_s2=self.acceleration_mm_s2)

    @property
    def run_up_s(self) -> float:
        """Time from the start of the motion to the first pattern: the ramp, and the time to settle."""
        return self.profile.ramp_time_s + self.settle_s if self.acquire == "cruise" else 0.0

    def position_mm(self, run_s: float, time_s: float) -> float:
        """Give the position that is commanded at a time after the first pattern, in a run of ``run_s`` seconds."""
        return self.positions_mm(run_s, [time_s])[0]

    def positions_mm(self, run_s: float, times_s: Sequence[float]) -> list[float]:
        """Give the position that is commanded at each of these times, as ``position_mm``."""
        profile, distance_mm, run_up_s = self.profile, self.end_mm(run_s) - self.start_mm, self.run_up_s
        return [self.start_mm + profile.travelled_mm(distance_mm, run_up_s + time_s) for time_s in times_s]

    def end_mm(self, run_s: float) -> float:
        """Give the position where the stage comes to rest after a run of ``run_s`` seconds: ramp, cruise, ramp."""
        profile = self.profile
        if self.acquire == "cruise":
            distance_mm = 2 * profile.ramp_mm + profile.velocity_mm_s * (2 * self.settle_s + run_s)
        else:
            # The ramp belongs to the run. A run shorter than the ramp still ends with a whole ramp down.
            distance_mm = 2 * profile.ramp_mm + profile.velocity_mm_s * max(0.0, run_s - profile.ramp_time_s)
        return self.start_mm + (distance_mm if self.velocity_mm_s > 0 else -distance_mm)


class Plan(_Numbers):
    """One run: what is shown, how often, how fast, and how the object moves meanwhile."""

    scheme: Annotated[SerializeAsAny[SchemeSettings], PlainValidator(settings_of)] = Field(
        default_factory=lambda: settings_of(DEFAULT_SCHEME)
    )
    """What one frame shows and how its values are decoded: the scheme's name, and its own settings in a table."""

    frames: Annotated[int, Field(gt=0, le=MOST_PATTERNS)]
    """Number of frames in the run, each with one displacement."""

    pattern_rate_hz: Annotated[float, Field(ge=1e-3)] = 20_000.0
    """Patterns per second. Boards keep whole microseconds: see ``picture_time_us``."""

    image_size: Annotated[int, Field(gt=0, le=4096)] = 128
    """Image pixels a side (m): a power of two, as Hadamard patterns need it."""

    superpixel: Annotated[int, Field(gt=0, le=4096)] = 2
    """Mirrors a side of one image pixel."""

    brightest_counts: Annotated[float, Field(gt=0, le=1e12)] | None = None
    """Counts expected of the brightest pattern, for the check against dead time. None skips the check."""

    motion: MotionPlan | None = None
    """What the stage does. None leaves it where it is."""

    run: Annotated[RunTable | None, Field(exclude_if=_is_none)] = None
    """What the run is about: title, user, sample, notes. None where nobody said."""

    stop_if: Annotated[StopTable | None, Field(exclude_if=_is_none)] = None
    """What ends the run early. None lets it come to its end."""

    @field_validator("run", "stop_if", mode="after")
    @classmethod
    def _none_if_it_says_nothing(cls, table: RunTable | StopTable | None) -> RunTable | StopTable | None:
        empty = not table.rules if isinstance(table, StopTable) else table == RunTable()
        return None if empty else table

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.image_size < 8 or self.image_size & (self.image_size - 1):
            raise ValueError(f"image_size is {self.image_size}: Hadamard patterns need a power of two, 8 or more")
        if self.pattern_rate_hz > 1e6:
            raise ValueError(f"pattern_rate_hz is {self.pattern_rate_hz:g}: at most 1e6, one microsecond a picture")
        self.scheme.check(self.image_size, self.superpixel)
        self._bearable()
        return self

    def _bearable(self) -> None:
        """Refuse a run that no bench lives long enough for, and no computer has room for, before any is taken."""
        if self.patterns > MOST_PATTERNS:
            most = MOST_PATTERNS // self.patterns_per_frame
            raise ValueError(f"frames is {self.frames}: at most {most} of this scheme, {MOST_PATTERNS} patterns")
        unique = self.patterns_per_frame * min(self.frames, self.image_size**2)
        gigabytes = unique * self.image_size**2 / 8 / 1e9
        if gigabytes > MOST_PATTERN_GB:
            raise ValueError(
                f"frames is {self.frames}: their patterns of {self.image_size} x {self.image_size} px take "
                f"{gigabytes:.3g} GB, where {MOST_PATTERN_GB:g} are the most; lower frames or image_size"
            )
        motion_s = 0.0 if self.motion is None else 2 * (self.motion.profile.ramp_time_s + self.motion.settle_s)
        days = (self.run_time_s + motion_s) / 86_400
        if days > MOST_DAYS:
            raise ValueError(f"frames is {self.frames}: this run takes {days:.3g} days, where {MOST_DAYS} are the most")

    @property
    def picture_time_us(self) -> int:
        """Whole microseconds from one pattern to the next, nearest to what ``pattern_rate_hz`` asks for."""
        return max(1, round(1e6 / self.pattern_rate_hz))

    @property
    def picture_time_s(self) -> float:
        """Time from one pattern to the next as the modulator keeps it."""
        return self.picture_time_us * 1e-6

    @property
    def patterns_per_frame(self) -> int:
        """Number of patterns in one frame of the scheme."""
        return self.scheme.patterns_per_frame

    @property
    def patterns(self) -> int:
        """Number of patterns in the run, the guard picture not counted."""
        return self.frames * self.patterns_per_frame

    @property
    def frame_time_s(self) -> float:
        """Time from one frame to the next."""
        return self.patterns_per_frame * self.picture_time_s

    @property
    def run_time_s(self) -> float:
        """Time from the first pattern to the end of the last, the guard picture not counted."""
        return self.frames * self.frame_time_s

    def _repr_html_(self) -> str:
        """Show the plan in a notebook, with what follows from it."""
        motion, size = self.motion, self.image_size
        rows = {
            "scheme": f"{self.scheme.name}, {self.patterns_per_frame} patterns a frame",
            "frames": f"{self.frames}, {self.patterns} patterns in {self.run_time_s:.3g} s",
            "rate": f"{self.pattern_rate_hz:g} patterns/s, {1 / self.frame_time_s:.4g} frames/s",
            "field": f"{size} x {size} px of {self.superpixel} x {self.superpixel} mirrors",
            "motion": "at rest"
            if motion is None
            else f"{motion.velocity_mm_s:g} mm/s from {motion.start_mm:g} to {motion.end_mm(self.run_time_s):.4g} mm",
        }
        return card("Plan", rows)

    def grid(self, columns: int = 1024, rows: int = 768) -> PixelGrid:
        """Give the image field, centred on a modulator of that many mirrors."""
        return PixelGrid(image_size=self.image_size, superpixel=self.superpixel, columns=columns, rows=rows)

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Read plan.toml.

        Raises:
            ConfigError: the file has mistakes; the error names all of them, with line and suggestion.
        """
        document = read_document(path_of(path))
        problems = scheme_problems(document)
        values = {key: value for key, value in document.values.items() if key != "scheme" or not problems}
        plan, others = validate_table(cls, values, document)
        of_scheme = type(settings_of(DEFAULT_SCHEME)).model_fields
        problems += [
            replace(other, suggestion="move it into a [scheme] table") if other.key in of_scheme else other
            for other in others
        ]
        if plan is None or problems:
            raise ConfigError(document.path, problems)
        return plan

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read the plan as a recording stores it. Version 0.1 stored the scheme's settings among the plan's own."""
        values: dict[str, Any] = json.loads(text)
        once = {key: values.pop(key) for key in _ONCE_OF_THE_PLAN if key in values}
        if once and isinstance(values.get("scheme"), str):
            values["scheme"] = {"name": values["scheme"], **once}
        return cls.model_validate(values)


def refuse_no_plan(plan: object) -> None:
    """Refuse what a script passes for a plan and is none.

    Raises:
        InputError: names its type.
    """
    if not isinstance(plan, Plan):
        raise InputError(
            saw=f"a {type(plan).__name__}", expected="a plan", remedy="read the file first: Plan.from_toml(path)"
        )
