"""The ``[light]`` table of bench.toml: what is known of how the bench differs from an ideal one."""

from typing import Annotated, Final, Literal, TypeAlias, cast

from pydantic import AfterValidator, BeforeValidator, Field

from protocols import Frozen

DeadTimeKind: TypeAlias = Literal["non-paralyzable", "paralyzable"]
"""What a photon does that comes in the dead time of another: nothing, or it prolongs it."""

StatedSource: TypeAlias = Literal["given", "calibrated"]
"""Who states a number: a person, or a calibration that measured it."""

_MOST_LEAK: Final = 0.4
_MOST_POINTS: Final = 33
"""Points along an axis that say how evenly the field is lit: what they describe is smooth."""


def _as_tuples(rows: object) -> object:
    """Give arrays of a file as the tuples that a strict model takes."""
    if not isinstance(rows, list):
        return rows
    listed = cast("list[object]", rows)
    return tuple(tuple(cast("list[object]", row)) if isinstance(row, list) else row for row in listed)


def _rectangular(rows: tuple[tuple[float, ...], ...]) -> tuple[tuple[float, ...], ...]:
    """Refuse rows of different lengths."""
    if len({len(row) for row in rows}) > 1:
        message = f"expected rows of the same length, saw {', '.join(str(len(row)) for row in rows)} numbers"
        raise ValueError(message)
    return rows


Brightness: TypeAlias = Annotated[float, Field(gt=0, le=10)]
Row: TypeAlias = Annotated[tuple[Brightness, ...], Field(min_length=2, max_length=_MOST_POINTS)]
Grid: TypeAlias = Annotated[
    tuple[Row, ...],
    Field(min_length=2, max_length=_MOST_POINTS),
    BeforeValidator(_as_tuples),
    AfterValidator(_rectangular),
]
"""Brightness of the field at points that are evenly spaced from its first edge to its last, row by row from the top."""


class Stated(Frozen):
    """A number with its uncertainty and who states it: ``leak = { value = 0.04, sigma = 0.002, source = "calibrated" }``."""

    value: Annotated[float, Field(ge=0, le=1)]
    """The number."""

    sigma: Annotated[float, Field(ge=0)] | None = None
    """Its standard deviation; None where nobody stated one."""

    source: StatedSource = "given"
    """Who states it."""


def _a_leak(stated: Stated) -> Stated:
    """Refuse a share of the picture before that no mirrors make."""
    if stated.value > _MOST_LEAK:
        message = f"expected a leak of {_MOST_LEAK:g} or less, saw {stated.value:g}"
        raise ValueError(message)
    return stated


class StatedProfile(Frozen):
    """A profile with its uncertainty and who states it."""

    values: Grid
    """How bright the field is lit."""

    sigma: Annotated[float, Field(ge=0)] | None = None
    """Standard deviation of a value; None where nobody stated one."""

    source: StatedSource = "given"
    """Who states it."""


class LightTable(Frozen):
    """Numbers that were measured on the bench. What is not given here is found from each run, where it says enough."""

    leak: Annotated[float, Field(ge=0, le=_MOST_LEAK)] | Annotated[Stated, AfterValidator(_a_leak)] | None = None
    """Share of the picture before in the light of a picture: mirrors that take 4 us to cross over make 0.04 at 20 kHz."""

    edge_loss: Annotated[float, Field(ge=0, le=1)] | Stated | None = None
    """Share of a lit mirror's light that is lost at each of its sides that borders a dark one."""

    profile: Grid | StatedProfile | None = None
    """How bright the field is lit: numbers at points evenly spaced from edge to edge, row by row from the top."""

    dead_time_kind: DeadTimeKind = "non-paralyzable"
    """Kind of the detector's dead time: paralyzable where pulses overlap, else non-paralyzable."""


NOTHING_KNOWN: Final = LightTable()
"""Of a bench that was never measured."""
