"""How large a number in bench.toml may be: far beyond every real bench, and well within what arithmetic and memory bear.

Settings come from files that others wrote. An echo after a billion seconds or a delay of 1e300 s would not fail: it would keep
a machine at work, or asleep, for ever.
"""

from typing import Annotated, TypeAlias

from pydantic import Field

Factor: TypeAlias = Annotated[float, Field(gt=0, le=1e6)]
"""A ratio of two quantities of a kind."""

Level: TypeAlias = Annotated[float, Field(ge=0, le=1e6)]
"""A ratio that may be 0."""

Offset: TypeAlias = Annotated[float, Field(ge=-1e6, le=1e6)]
"""What is added to a signal, of either sign."""

Part: TypeAlias = Annotated[float, Field(ge=0, le=1)]
"""A part of a whole, or a probability."""

Seconds: TypeAlias = Annotated[float, Field(ge=0, le=86_400)]
"""A delay or a patience: a day at most."""

SomeSeconds: TypeAlias = Annotated[float, Field(gt=0, le=86_400)]
"""The same, above 0."""

Instant: TypeAlias = Annotated[float, Field(ge=0, le=10)]
"""Part of the time of a picture: no picture is longer than 10 s."""

Microseconds: TypeAlias = Annotated[int, Field(gt=0, le=1_000_000_000)]
"""Whole microseconds, 1000 s at most."""

Hertz: TypeAlias = Annotated[float, Field(gt=0, le=1e12)]
"""A rate of edges, counts or words."""

DarkHertz: TypeAlias = Annotated[float, Field(ge=0, le=1e9)]
"""A rate of dark counts."""

PlacePx: TypeAlias = Annotated[float, Field(ge=-1e6, le=1e6)]
"""A place in the image, or far outside of it."""

PlaceMm: TypeAlias = Annotated[float, Field(ge=-1e6, le=1e6)]
"""A place on a stage: a kilometre to either side."""

LengthMm: TypeAlias = Annotated[float, Field(gt=0, le=1e6)]
"""A length, or one gone through in a second."""

StepMm: TypeAlias = Annotated[float, Field(ge=1e-9, le=1e3)]
"""The step of a stage: a picometre or more."""

Angle: TypeAlias = Annotated[float, Field(ge=-3600, le=3600)]
"""Degrees, ten turns to either side."""

Index: TypeAlias = Annotated[int, Field(ge=0, lt=2**31)]
"""Index of a picture, a bin, a sample."""

Signed: TypeAlias = Annotated[int, Field(ge=-(2**31), lt=2**31)]
"""A shift of rows or counts, to either side."""

ErrorCode: TypeAlias = Annotated[int, Field(ge=-(2**31), lt=0)]
"""What a library answers instead of 0."""

Number: TypeAlias = Annotated[int, Field(gt=0, lt=2**31)]
"""How many of something that is not laid out in memory."""

Mirrors: TypeAlias = Annotated[int, Field(gt=0, le=8192)]
"""Mirrors a side: the largest arrays have 4096."""

LaidOut: TypeAlias = Annotated[int, Field(gt=0, le=10_000_000)]
"""How many of something of which each is laid out in memory."""

Seed: TypeAlias = Annotated[int, Field(ge=0, lt=2**63)]
"""Makes a run repeatable to the bit."""
