"""The queue of one listener: bounded, oldest first, never in anybody's way."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from instrument.session import BlockEvent, Channel, Event, Feed, FindingEvent, FinishedEvent, PhaseEvent, UploadEvent
from tests.instrument.live.streams import block


def blocks_of(events: list[Event] | None) -> list[tuple[int, int]]:
    return [(event.first_pattern, event.patterns) for event in events or [] if isinstance(event, BlockEvent)]


def counted(first: int, patterns: int) -> BlockEvent:
    return BlockEvent.of(block(first, np.ones(patterns)))


def test_a_full_feed_drops_its_oldest_blocks_and_counts_them() -> None:
    """Seven blocks of 10 into room for 35: the last three stay, and what is no block stays too."""
    feed = Feed(35)
    feed.put(PhaseEvent(phase="counting"))
    for k in range(7):
        feed.put(counted(10 * k, 10))
    assert feed.blocks_dropped == 4
    assert feed.patterns == 30
    taken = feed.take(wait=True)
    assert taken is not None
    assert taken[0] == PhaseEvent(phase="counting")
    assert blocks_of(taken) == [(40, 10), (50, 10), (60, 10)]
    assert feed.patterns == 0


def test_the_newest_block_stays_however_large_it_is() -> None:
    feed = Feed(35)
    feed.put(counted(0, 10))
    feed.put(counted(10, 1000))
    assert blocks_of(feed.take(wait=True)) == [(10, 1000)]
    assert feed.blocks_dropped == 1


def test_of_uploads_only_the_newest_waits() -> None:
    feed = Feed()
    for stored in range(1, 85):
        feed.put(UploadEvent(stored=stored, total=84))
    assert feed.take(wait=True) == [UploadEvent(stored=84, total=84)]


def test_a_closed_feed_is_emptied_and_then_ends() -> None:
    feed = Feed()
    assert feed.take(wait=False) == []
    feed.put(counted(0, 6))
    feed.close()
    feed.put(counted(6, 6))
    assert blocks_of(feed.take(wait=True)) == [(0, 6)]
    assert feed.take(wait=True) is None


def test_a_feed_that_forgets_ends_at_once() -> None:
    feed = Feed()
    feed.put(counted(0, 6))
    feed.close(forget=True)
    assert feed.take(wait=True) is None
    assert feed.blocks_dropped == 0


def test_a_follower_may_tell_what_it_finds_and_nothing_of_the_run() -> None:
    class Follower:
        name = "the follower"

        def follow(self, feed: Feed, publish: Callable[[FindingEvent], None]) -> None:
            while (events := feed.take(wait=True)) is not None:
                for event in events:
                    publish(event if isinstance(event, FinishedEvent) else FindingEvent(message="a block"))  # type: ignore[arg-type]

    channel, heard = Channel(), list[Event]()
    channel.subscribe(heard.append)
    listening = channel.subscribe(Follower())
    channel.publish(counted(0, 6))
    channel.publish(FinishedEvent(outcome="done"))
    assert channel.join(10)
    assert sorted(event.kind for event in heard) == ["block", "finding", "finished"]
    assert isinstance(listening.error, TypeError)
    assert channel.failures[0].listener == "the follower"


class FeedMachine(RuleBasedStateMachine):
    """Whatever is put and taken: blocks come in order, at most the newest ones wait, and none is lost uncounted."""

    def __init__(self) -> None:
        super().__init__()
        self.feed = Feed(100)
        self.put = self.taken = self.first = 0
        self.last_taken = -1

    @rule(patterns=st.integers(1, 150))
    def put_block(self, patterns: int) -> None:
        self.feed.put(counted(self.first, patterns))
        self.first += patterns
        self.put += 1

    @rule()
    def put_other(self) -> None:
        self.feed.put(FindingEvent(message="x"))

    @rule()
    def take(self) -> None:
        for first, _ in blocks_of(self.feed.take(wait=False)):
            assert first > self.last_taken
            self.last_taken = first
            self.taken += 1
        assert self.put == self.taken + self.feed.blocks_dropped

    @invariant()
    def bounded(self) -> None:
        assert self.feed.patterns <= max(100, 150)


TestFeedMachine = pytest.mark.filterwarnings("ignore::hypothesis.errors.NonInteractiveExampleWarning")(
    FeedMachine.TestCase
)
TestFeedMachine.settings = settings(max_examples=40, stateful_step_count=30, deadline=None)
