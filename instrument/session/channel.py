"""From a run to whoever listens. Listeners are guests: none can delay, end or change a run."""

import time
from collections.abc import Callable, Sequence
from threading import Lock, Thread
from typing import Final, Protocol, TypeAlias, runtime_checkable

from instrument.session.events import Event, FindingEvent, FinishedEvent, ImageEvent, TrackingEvent
from instrument.session.feed import MAX_PATTERNS, Feed
from instrument.session.snapshot import ListenerFailure

GRACE_S: Final = 1.0
"""How long a call that ends a run waits for its listeners to take what is left."""


@runtime_checkable
class Follower(Protocol):
    """A listener that takes events when it has time for them, and may tell what it makes of them."""

    def follow(self, feed: Feed, publish: "Publish") -> None:
        """Take events until there are no more. Called once, on a thread of its own.

        Args:
            feed: the events.
            publish: tells all other listeners.
        """
        ...


Made: TypeAlias = TrackingEvent | ImageEvent | FindingEvent
"""What a follower may tell; the other events are the run's own."""

Publish: TypeAlias = Callable[[Made], None]
"""Tells all other listeners."""


Listener: TypeAlias = Callable[[Event], None] | Follower
"""Who is told of events: a function, called with each on a thread of its own, or a ``Follower``."""


class Subscription:
    """One listener with its feed and its thread. A listener that raises is told nothing more."""

    def __init__(self, listener: Listener, channel: "Channel", max_patterns: int) -> None:
        """Prepare; ``start`` starts the thread."""
        self.name = str(getattr(listener, "name", "") or getattr(listener, "__qualname__", type(listener).__name__))
        """``listener.name`` where it has one, for messages."""
        self.error: Exception | None = None
        """What the listener raised; None where nothing was."""
        self.feed = Feed(max_patterns)
        """Its events."""
        self.publishes = isinstance(listener, Follower)
        """Whether it may tell others of what it makes."""
        self._listener = listener
        self._channel = channel
        self._thread = Thread(target=self._work, name=f"kinopix-listener {self.name}", daemon=True)

    def start(self) -> None:
        """Start to listen."""
        self._thread.start()

    def join(self, timeout_s: float | None = None) -> bool:
        """Wait until the listener has taken everything, and tell whether it has."""
        self._thread.join(timeout_s)
        return not self._thread.is_alive()

    def _work(self) -> None:
        try:
            if isinstance(self._listener, Follower):
                self._listener.follow(self.feed, self._publish)
            else:
                while (events := self.feed.take(wait=True)) is not None:
                    for event in events:
                        self._listener(event)
        except Exception as error:  # noqa: BLE001 - whatever it is, the run goes on and the snapshot tells of it
            self.error = error
        finally:
            self.feed.close(forget=True)
            self._channel.left(self)

    def _publish(self, event: Event) -> None:
        if not isinstance(event, Made):
            raise TypeError(f"a listener cannot publish a {type(event).__name__}")
        self._channel.publish(event, without=self)


class Channel:
    """Gives each event to each listener, in the order in which they were published."""

    def __init__(self, take_note: Callable[[Event], None] | None = None) -> None:
        """Start without listeners.

        Args:
            take_note: called with each event before anybody is told, one at a time; must return at once.
        """
        self._take_note = take_note
        self._lock = Lock()
        self._feeds: list[Feed] = []
        self._subscriptions: list[Subscription] = []
        self._publishing: set[Subscription] = set()
        self._finished: FinishedEvent | None = None

    def subscribe(self, listener: Listener, *, max_patterns: int = MAX_PATTERNS) -> Subscription:
        """Tell one more listener of all that comes from now on; after the end, of the finished event.

        Args:
            listener: a function or a ``Follower``.
            max_patterns: how many patterns may wait for it; beyond, the oldest blocks are dropped and counted.
        """
        subscription = Subscription(listener, self, max_patterns)
        with self._lock:
            self._subscriptions.append(subscription)
            if subscription.publishes and self._finished is None:
                self._publishing.add(subscription)
            self._add(subscription.feed)
        subscription.start()
        return subscription

    def feed(self, *, max_patterns: int = MAX_PATTERNS) -> Feed:
        """Give a feed of all that comes from now on, to iterate over; after the end, of the finished event."""
        feed = Feed(max_patterns)
        with self._lock:
            self._add(feed)
        return feed

    def _add(self, feed: Feed) -> None:
        self._feeds.append(feed)
        if self._finished is not None:
            feed.put(self._finished)
            feed.close()

    def publish(self, event: Event, *, without: Subscription | None = None) -> None:
        """Tell everybody, but for one; returns at once. The finished event closes the feeds.

        Listeners that only listen are told what followers still make after it, such as a last image.
        """
        with self._lock:
            if self._take_note is not None:
                self._take_note(event)
            for feed in self._feeds:
                if without is None or feed is not without.feed:
                    feed.put(event)
            if isinstance(event, FinishedEvent):
                self._finished = event
                for subscription in self._publishing:
                    subscription.feed.close()
                self._close_when_quiet()

    def left(self, subscription: Subscription) -> None:
        """Take note that a listener has ended."""
        with self._lock:
            self._publishing.discard(subscription)
            self._close_when_quiet()

    def _close_when_quiet(self) -> None:
        if self._finished is not None and not self._publishing:
            for feed in self._feeds:
                feed.close()

    def join(self, timeout_s: float | None = None) -> bool:
        """Wait until every listener has taken everything, and tell whether all have; for after the finished event."""
        end_s = None if timeout_s is None else time.monotonic() + timeout_s
        waits = [s.join(None if end_s is None else max(0.0, end_s - time.monotonic())) for s in self._all()]
        return all(waits)

    @property
    def failures(self) -> tuple[ListenerFailure, ...]:
        """Listeners that raised."""
        return tuple(ListenerFailure(listener=s.name, error=str(s.error)) for s in self._all() if s.error is not None)

    @property
    def blocks_dropped(self) -> int:
        """Blocks that listeners missed because they were late, all together."""
        return sum(subscription.feed.blocks_dropped for subscription in self._all())

    def _all(self) -> Sequence[Subscription]:
        with self._lock:
            return list(self._subscriptions)
