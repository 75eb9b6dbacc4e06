"""The H10682 head itself: power in, pulses out. It has no software, only figures, and most of them are second-hand.

What is doubtful (fact sheet h10682-daq, sections 3 and 13): the maker's own data sheet was not at hand. The dark count of the
-210 is given as 600 (at most 1000) a second in one document and as 50 (at most 100) in older ones, so a dark rate is only ever
one that was measured on the rig, in darkness, after half an hour. The pulse-pair resolution of 20 ns agrees with the stated
10 % loss at 5e6 counts a second by the non-paralyzable model; the dead time of the whole chain is still a thing to measure.
"""

from pydantic import Field, NonNegativeFloat, PositiveFloat, PositiveInt

from protocols import CounterLimits, Frozen

NAME = "pmt"
"""Name of the counter in errors and recordings."""

LINEAR_LOSS = 0.1
"""Share of counts lost at the count rate that the data sheet calls the limit of linearity."""


class Head(Frozen):
    """One H10682 head."""

    model: str = "H10682-210"
    """Model, as on the head's label: -110 (380 to 700 nm) or -210 (230 to 700 nm)."""

    dead_time_s: PositiveFloat = 20e-9
    """Pulse-pair resolution in seconds, second-hand [S]."""

    dark_rate_hz: NonNegativeFloat = 0.0
    """Dark counts a second, measured with the shutter closed after 30 minutes of darkness; 0 where it was not measured."""

    system_dead_time_s: PositiveFloat | None = Field(default=None)
    """Dead time of head and counter together in seconds, as measured on the rig. None takes the longer of the two."""


def linear_limit_hz(dead_time_s: float) -> float:
    """Measured count rate at which a non-paralyzable chain loses 10 %: loss = M t, so M = 0.1 / t.

    >>> round(linear_limit_hz(20e-9))
    5000000
    """
    return LINEAR_LOSS / dead_time_s


def counter_limits(
    head: Head,
    *,
    counter_dead_time_s: float,
    max_sync_rate_hz: float,
    max_bins: PositiveInt | None = None,
    edge_time_resolution_s: float | None = None,
    max_unread_bins: PositiveInt | None = None,
) -> CounterLimits:
    """Limits of a head on a counter board; the slower of the two decides (fact sheet, section 2, fact 3)."""
    dead_time_s = head.system_dead_time_s or max(head.dead_time_s, counter_dead_time_s)
    return CounterLimits(
        max_sync_rate_hz=max_sync_rate_hz,
        max_count_rate_hz=linear_limit_hz(dead_time_s),
        dead_time_s=dead_time_s,
        dark_rate_hz=head.dark_rate_hz,
        max_bins=max_bins,
        edge_time_resolution_s=edge_time_resolution_s,
        max_unread_bins=max_unread_bins,
    )
