"""One listener's queue of events: bounded, so that whoever listens slowly loses old events and delays nobody."""

from collections import Counter, deque
from collections.abc import Iterator
from threading import Lock
from typing import Final

from instrument.session.bell import Bell
from instrument.session.events import BlockEvent, Event, FinishedEvent

MAX_PATTERNS: Final = 60_000
"""Patterns that may wait: three seconds at 20 kHz, half a megabyte."""

_ROOM: Final = {"upload": 1, "tracking": 1000, "image": 4}
"""Events of other kinds that may wait; those that are not named are few. Of uploads only the newest says anything."""


class Feed:
    """Events on their way to one listener, oldest first. Iterating over it waits for each, and ends when the run is over."""

    def __init__(self, max_patterns: int = MAX_PATTERNS) -> None:
        """Keep blocks of at most so many patterns, and at least the newest block."""
        self._room = {"block": max_patterns, **_ROOM}
        self._events: deque[Event] = deque()
        self._waiting: Counter[str] = Counter()
        self._dropped: Counter[str] = Counter()
        self._closed = False
        self._lock = Lock()
        self._changed = Bell()

    @property
    def blocks_dropped(self) -> int:
        """Blocks thrown away so far because the listener was late."""
        return self._dropped["block"]

    @property
    def patterns(self) -> int:
        """Patterns that wait."""
        return self._waiting["block"]

    def put(self, event: Event) -> None:
        """Add an event and return at once; into a closed feed nothing goes any more."""
        with self._lock:
            if self._closed:
                return
            self._events.append(event)
            self._waiting[event.kind] += _size(event)
            self._drop_oldest(event.kind)
        self._changed.ring()

    def _drop_oldest(self, kind: str) -> None:
        room = self._room.get(kind)
        if room is None:
            return
        while self._waiting[kind] > room:
            oldest = next(event for event in self._events if event.kind == kind)
            if oldest is self._events[-1]:
                return
            self._events.remove(oldest)
            self._waiting[kind] -= _size(oldest)
            self._dropped[kind] += 1

    def take(self, *, wait: bool) -> list[Event] | None:
        """Give all events that are there, oldest first.

        Args:
            wait: whether to wait for one; without, the list may be empty.

        Returns:
            None when the feed is closed and empty.
        """
        while True:
            with self._lock:
                if self._events or not (wait or self._closed):
                    taken = list(self._events)
                    self._events.clear()
                    self._waiting.clear()
                    return taken
                if self._closed:
                    self._changed.ring()  # for others who take from it
                    return None
            self._changed.wait()

    def close(self, *, forget: bool = False) -> None:
        """Take no more events; with ``forget``, those that wait are thrown away too, uncounted."""
        with self._lock:
            self._closed = True
            if forget:
                self._events.clear()
                self._waiting.clear()
        self._changed.ring()

    def __iter__(self) -> Iterator[Event]:
        """Give each event when it comes; the finished event is the last."""
        while (event := self._next()) is not None:
            yield event
            if isinstance(event, FinishedEvent):
                return

    def _next(self) -> Event | None:
        while True:
            with self._lock:
                if self._events:
                    event = self._events.popleft()
                    self._waiting[event.kind] -= _size(event)
                    return event
                if self._closed:
                    self._changed.ring()  # for others who take from it
                    return None
            self._changed.wait()


def _size(event: Event) -> int:
    return event.patterns if isinstance(event, BlockEvent) else 1
