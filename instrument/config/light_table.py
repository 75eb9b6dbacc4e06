"""The ``[light]`` table of bench.toml: what is known of how the bench differs from an ideal one."""

from typing import Annotated, Final, Literal, TypeAlias

from pydantic import Field

from protocols import Frozen

DeadTimeKind: TypeAlias = Literal["non-paralyzable", "paralyzable"]
"""What a photon does that comes in the dead time of another: nothing, or it prolongs it."""


class LightTable(Frozen):
    """Numbers that were measured on the bench. What is not given here is found from each run, where it says enough."""

    leak: Annotated[float, Field(ge=0, le=0.4)] | None = None
    """Share of the picture before in the light of a picture: mirrors that take 4 us to cross over make 0.04 at 20 kHz."""

    edge_loss: Annotated[float, Field(ge=0, le=1)] | None = None
    """Share of a lit mirror's light that is lost at each of its sides that borders a dark one."""

    dead_time_kind: DeadTimeKind = "non-paralyzable"
    """Kind of the detector's dead time: paralyzable where pulses overlap, else non-paralyzable."""


NOTHING_KNOWN: Final = LightTable()
"""Of a bench that was never measured."""
