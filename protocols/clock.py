"""Time as the bench keeps it: the host's monotonic clock, or a simulator's virtual one."""

import time
from typing import Protocol, runtime_checkable


@runtime_checkable
class Clock(Protocol):
    """A clock tells the time in seconds since some fixed moment. Everything that waits, waits on the clock it was given."""

    def now_s(self) -> float:
        """Give the time now in seconds. It never goes back."""
        ...

    def sleep_s(self, duration_s: float) -> None:
        """Return when ``duration_s`` seconds have passed on this clock. A virtual clock passes them at once."""
        ...


class MonotonicClock:
    """The host's monotonic clock: the one for real hardware."""

    def now_s(self) -> float:
        """Give the seconds of ``time.monotonic``."""
        return time.monotonic()

    def sleep_s(self, duration_s: float) -> None:
        """Sleep for ``duration_s`` seconds; a negative duration returns at once."""
        time.sleep(max(0.0, duration_s))  # noqa: TID251 - the one real wait
