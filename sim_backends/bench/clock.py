"""The time of a simulated bench: virtual by default, real on request."""

import threading
import time
from typing import Protocol


class BenchClock(Protocol):
    """A ``protocols.Clock`` that can also be told to reach a moment."""

    def now_s(self) -> float:
        """Seconds since the bench was built."""
        ...

    def sleep_s(self, duration_s: float) -> None:
        """Return when ``duration_s`` seconds have passed on this clock."""
        ...

    def advance_to(self, time_s: float) -> None:
        """Return when this clock shows ``time_s`` or later. It never goes back."""
        ...


class VirtualClock:
    """Time that passes at once when somebody waits, and stands still otherwise. Safe to use from many threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._now_s = 0.0

    def now_s(self) -> float:
        """Virtual seconds since the bench was built."""
        return self._now_s

    def sleep_s(self, duration_s: float) -> None:
        """Let ``duration_s`` seconds pass at once; a negative duration changes nothing."""
        with self._lock:
            self._now_s += max(0.0, duration_s)

    def advance_to(self, time_s: float) -> None:
        """Let the time until ``time_s`` pass at once; a moment that is past changes nothing."""
        with self._lock:
            self._now_s = max(self._now_s, time_s)


class RealTimeClock:
    """The host's monotonic clock, counted from when the bench was built: for live views and for soak tests."""

    def __init__(self) -> None:
        self._start_s = time.monotonic()

    def now_s(self) -> float:
        """Seconds since the bench was built."""
        return time.monotonic() - self._start_s

    def sleep_s(self, duration_s: float) -> None:
        """Sleep for ``duration_s`` seconds."""
        time.sleep(max(0.0, duration_s))  # noqa: TID251  (this is the clock that the others wait on)

    def advance_to(self, time_s: float) -> None:
        """Sleep until ``time_s``."""
        self.sleep_s(time_s - self.now_s())
