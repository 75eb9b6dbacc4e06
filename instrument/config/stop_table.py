"""The ``[stop_if]`` table of plan.toml: what ends a run before its last pattern."""

from typing import Annotated, TypeAlias

from pydantic import Field

from protocols import Frozen

HoldTime: TypeAlias = Annotated[float, Field(ge=0, le=86_400)]
"""How long something must hold, in seconds."""


class StopTable(Frozen):
    """Rules that end a run early, each with the time for which it must hold without a break; 0 is a single frame.

    The run ends as by Ctrl-C: devices safe, the file closed, what was recorded kept.
    """

    too_bright_s: HoldTime | None = None
    """Stop when every frame of so many seconds has a pattern above the counter's linear limit. None never stops for it."""

    light_gone_s: HoldTime | None = None
    """Stop when the light is gone for so many seconds: see `light_below`. None never stops for it."""

    light_below: Annotated[float, Field(gt=0, lt=1)] = 0.1
    """The light is gone where a frame, dark counts taken off, has less than this share of the brightest frame so far; of
    a detector that counts photons also where a frame has no more than dark counts explain."""

    audit_fails_s: HoldTime | None = None
    """Stop when the timing audit fails every frame of so many seconds: sync edges are missing, doubled or irregular in each.
    None never stops for it."""

    @property
    def rules(self) -> dict[str, float]:
        """Give for how long each rule that there is must hold, by its key; empty where nothing ends the run."""
        times_s = {
            "too_bright_s": self.too_bright_s,
            "light_gone_s": self.light_gone_s,
            "audit_fails_s": self.audit_fails_s,
        }
        return {key: hold_s for key, hold_s in times_s.items() if hold_s is not None}
