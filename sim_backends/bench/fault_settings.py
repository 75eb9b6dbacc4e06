"""Faults in ``[scene]``: what goes wrong in every run."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from protocols.values import Frozen
from sim_backends.bench.bounds import Index, LaidOut


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
