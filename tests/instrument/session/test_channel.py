"""Who is told what, and when: listeners and feeds of a channel, held by flags where the order matters."""

from collections.abc import Iterator
from threading import Event as Flag

import numpy as np
import pytest

from instrument.session import (
    BlockEvent,
    Channel,
    Event,
    Feed,
    FindingEvent,
    FinishedEvent,
    ImageEvent,
    ListenerFailure,
    PhaseEvent,
    TrackingEvent,
    UploadEvent,
)
from instrument.session.channel import Publish
from instrument.session.feed import MAX_PATTERNS
from tests.instrument.live.streams import block

DONE = FinishedEvent(outcome="done")


def _counted(first: int, patterns: int) -> BlockEvent:
    return BlockEvent.of(block(first, np.ones(patterns)))


def _found(*messages: str) -> list[Event]:
    return [FindingEvent(message=message) for message in messages]


def _taken(feed: Feed) -> list[Event]:
    return feed.take(wait=False) or []


class Held:
    """A follower that takes nothing until it is let go, and then tells what it was told to tell."""

    name = "the held one"

    def __init__(self, *told: FindingEvent) -> None:
        self.there, self.go, self.told, self.heard = Flag(), Flag(), told, list[Event]()

    def follow(self, feed: Feed, publish: Publish) -> None:
        self.there.set()
        assert self.go.wait(20)
        self.heard += list(feed)
        for event in self.told:
            publish(event)


def test_the_run_takes_note_of_an_event_before_anybody_is_told() -> None:
    noted: list[tuple[Event, int]] = []
    channel = Channel(lambda event: noted.append((event, len(_taken(feed)))))
    feed = channel.feed()
    for event in (PhaseEvent(phase="counting"), DONE):
        channel.publish(event)
    assert noted == [(PhaseEvent(phase="counting"), 0), (DONE, 1)]
    assert _taken(feed) == [DONE]
    assert feed.take(wait=True) is None


def test_a_feed_has_what_comes_from_then_on_and_after_the_end_the_end_alone() -> None:
    channel = Channel()
    early = channel.feed()
    channel.publish(PhaseEvent(phase="counting"))
    late = channel.feed()
    channel.publish(FindingEvent(message="x"))
    channel.publish(DONE)
    assert list(early) == [PhaseEvent(phase="counting"), FindingEvent(message="x"), DONE]
    assert list(late) == [FindingEvent(message="x"), DONE]
    heard: list[Event] = []
    channel.subscribe(heard.append)
    assert channel.join(10)
    assert heard == [DONE] == list(channel.feed())


def test_what_a_follower_tells_after_the_end_reaches_all_others_and_not_itself() -> None:
    channel, heard, held = Channel(), list[Event](), Held(FindingEvent(message="late"), FindingEvent(message="later"))
    channel.subscribe(heard.append)
    channel.subscribe(held)
    assert held.there.wait(10)
    channel.publish(DONE)
    assert not channel.join(0)
    held.go.set()
    assert channel.join(10)
    assert held.heard == [DONE]
    assert heard == [DONE, *_found("late", "later")]
    assert channel.failures == ()


def test_a_follower_that_comes_after_the_end_keeps_nobody_waiting() -> None:
    channel, held = Channel(), Held()
    channel.publish(DONE)
    feed = channel.feed()
    channel.subscribe(held)
    assert feed.take(wait=True) == [DONE]
    assert feed.take(wait=True) is None
    held.go.set()
    assert channel.join(10)
    assert held.heard == [DONE]


def test_blocks_missed_are_those_of_all_listeners_together() -> None:
    """Five blocks of 10: of room for 30 two are missed, of room for 10 four; of plenty of room none."""
    channel, held = Channel(), [Held(), Held(), Held()]
    subscriptions = [
        channel.subscribe(listener, max_patterns=room)
        for listener, room in zip(held, (30, 10, MAX_PATTERNS), strict=True)
    ]
    for k in range(5):
        channel.publish(_counted(10 * k, 10))
    assert [subscription.feed.blocks_dropped for subscription in subscriptions] == [2, 4, 0]
    assert channel.blocks_dropped == 6
    channel.publish(DONE)
    for listener in held:
        listener.go.set()
    assert channel.join(10)
    assert [len(listener.heard) for listener in held] == [4, 2, 6]


def test_a_listener_that_raises_is_named_and_its_feed_is_emptied_for_good() -> None:
    def breaks(event: Event) -> None:
        raise ValueError(f"cannot stand a {event.kind}")

    channel, heard = Channel(), list[Event]()
    broken, well = channel.subscribe(breaks), channel.subscribe(heard.append)
    channel.publish(PhaseEvent(phase="arming"))
    assert broken.join(10)
    channel.publish(DONE)
    assert channel.join(10)
    assert channel.failures == (ListenerFailure(listener=breaks.__qualname__, error="cannot stand a phase"),)
    assert (broken.feed.take(wait=True), well.error) == (None, None)
    assert heard == [PhaseEvent(phase="arming"), DONE]


@pytest.mark.parametrize("room", [pytest.param(1000, id="tracking"), pytest.param(4, id="image")])
def test_of_paths_a_thousand_wait_and_of_images_four(room: int) -> None:
    """The oldest two are gone, and what is of another kind stays where it was."""

    def event(frame: int) -> TrackingEvent | ImageEvent:
        array = np.zeros((1, 2))
        if room == 4:
            return ImageEvent(frame=frame, image=array)
        return TrackingEvent(frame=frame, displacement_px=array)

    feed = Feed()
    feed.put(PhaseEvent(phase="counting"))
    for frame in range(room + 2):
        feed.put(event(frame))
    taken = _taken(feed)
    assert taken[0] == PhaseEvent(phase="counting")
    assert [e.frame for e in taken if isinstance(e, TrackingEvent | ImageEvent)] == list(range(2, room + 2))
    assert feed.blocks_dropped == 0


def test_three_seconds_at_20_khz_wait_and_not_a_pattern_more() -> None:
    feed = Feed()
    for first in range(0, 60_000, 20_000):
        feed.put(_counted(first, 20_000))
    assert (feed.patterns, feed.blocks_dropped) == (60_000, 0)
    feed.put(_counted(60_000, 1))
    assert (feed.patterns, feed.blocks_dropped) == (40_001, 1)


def test_iterating_makes_room_and_ends_with_the_finished_event_whatever_comes_after() -> None:
    feed = Feed(20)
    feed.put(_counted(0, 20))
    events: Iterator[Event] = iter(feed)
    assert next(events).kind == "block"
    assert feed.patterns == 0
    feed.put(_counted(20, 20))
    feed.put(DONE)
    feed.put(UploadEvent(stored=1, total=1))
    assert [event.kind for event in events] == ["block", "finished"]
    assert feed.blocks_dropped == 0
    assert _taken(feed) == [UploadEvent(stored=1, total=1)]


def test_a_feed_that_is_closed_without_an_end_ends_after_what_it_has() -> None:
    feed = Feed()
    feed.put(_counted(0, 6))
    feed.close()
    assert [event.kind for event in feed] == ["block"]
    assert list(feed) == []
