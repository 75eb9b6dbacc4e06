"""The live analysis on its thread, beside a run."""

from pathlib import Path
from threading import Event as ThreadEvent
from threading import enumerate as all_threads

import numpy as np

from instrument.acquisition import AlignedBlock
from instrument.live import LiveAnalysis
from instrument.plan import Plan
from instrument.session import BlockEvent, Channel, Event, FinishedEvent, ImageEvent, Instrument, TrackingEvent
from instrument.session.feed import MAX_PATTERNS
from instrument.storage import open_recording
from instrument.tracking import StreamingTracker
from protocols import InputError
from tests.instrument.live.streams import FRAMES, PLAN, blocks, psnr, run
from tests.support.benches import SMALL, bench_toml

DONE = FinishedEvent(outcome="done")


def _threads() -> list[str]:
    return [thread.name for thread in all_threads() if "live analysis" in thread.name]


class Stream:
    """A run's channel with the live analysis on it, and a list of all that it tells."""

    def __init__(self, live: LiveAnalysis, *, max_patterns: int = MAX_PATTERNS) -> None:
        self.channel = Channel()
        self.heard: list[Event] = []
        self.channel.subscribe(self.heard.append)
        self.listening = self.channel.subscribe(live, max_patterns=max_patterns)

    def send(self, block: AlignedBlock) -> None:
        self.channel.publish(BlockEvent.of(block))

    def end(self, how: FinishedEvent = DONE) -> None:
        self.channel.publish(how)
        assert self.channel.join(20)

    @property
    def tracked(self) -> list[TrackingEvent]:
        return [event for event in self.heard if isinstance(event, TrackingEvent)]

    @property
    def images(self) -> list[ImageEvent]:
        return [event for event in self.heard if isinstance(event, ImageEvent)]


def test_it_follows_every_frame_and_ends_with_the_polished_image() -> None:
    recording = run()
    assert recording.truth is not None
    live = LiveAnalysis(PLAN)
    stream = Stream(live)
    for piece in blocks(recording.values, [250]):
        stream.send(piece)
    stream.end()
    assert stream.listening.error is None
    followed = np.concatenate([event.displacement_px for event in stream.tracked])
    assert np.array_equal(followed, StreamingTracker(PLAN).push(recording.values))
    assert [event.final for event in stream.tracked] == [False] * (len(stream.tracked) - 1) + [True]
    assert stream.images[-1].final
    assert psnr(stream.images[-1].image, recording.truth.image) > 30
    assert (live.counters.frames, live.counters.frames_dropped) == (FRAMES, 0)
    assert stream.listening.feed.blocks_dropped == 0
    # One image is due every 63 frames (18.9 ms): nine in 600.
    assert live.counters.images + live.counters.images_skipped == 9
    assert not _threads()


class _Gate:
    """A clock that stands for an hour of work, and holds whoever looks at it until it is opened."""

    def __init__(self) -> None:
        self.busy, self.open = ThreadEvent(), ThreadEvent()

    def now_s(self) -> float:
        self.busy.set()
        assert self.open.wait(10)
        return 0.0

    def sleep_s(self, duration_s: float) -> None:
        raise AssertionError(f"nothing may wait, {duration_s} s here")


def test_while_it_is_busy_the_queue_fills_drops_its_oldest_and_counts_them() -> None:
    """Frames 0 to 99 keep it busy; then five blocks of 100 frames come into room for two."""
    gate = _Gate()
    live = LiveAnalysis(PLAN, clock=gate)
    stream = Stream(live, max_patterns=1200)
    pieces = list(blocks(run().values, [600]))
    stream.send(pieces[0])
    assert gate.busy.wait(10)
    for piece in pieces[1:]:
        stream.send(piece)  # returns, although nobody takes anything
    assert stream.listening.feed.blocks_dropped == 3
    gate.open.set()
    stream.end()
    assert stream.listening.error is None
    assert (live.counters.frames, live.counters.frames_dropped) == (FRAMES, 300)
    assert stream.tracked[-1].final


class _SlowClock:
    """An hour goes by at each look: every image takes far too long."""

    def __init__(self) -> None:
        self.looks = 0

    def now_s(self) -> float:
        self.looks += 1
        return 3600.0 * self.looks

    def sleep_s(self, duration_s: float) -> None:
        raise AssertionError(f"nothing may wait, {duration_s} s here")


def test_on_a_slow_machine_an_image_gets_half_the_effort() -> None:
    live = LiveAnalysis(PLAN, clock=_SlowClock())
    stream = Stream(live)
    one_at_a_time = ThreadEvent()
    stream.channel.subscribe(lambda event: one_at_a_time.set() if isinstance(event, TrackingEvent) else None)
    for piece in blocks(run().values[:378], [378]):
        one_at_a_time.clear()
        stream.send(piece)
        assert one_at_a_time.wait(10)
    stream.end()
    assert live.effort == 0.5
    assert stream.listening.error is None
    assert stream.tracked[-1].final


def test_an_error_of_its_own_is_kept_and_nothing_else_happens() -> None:
    """Blocks that come in the wrong order are refused."""
    stream = Stream(LiveAnalysis(PLAN))
    pieces = list(blocks(run().values, [600]))
    stream.send(pieces[1])
    stream.send(pieces[0])
    stream.end()
    assert isinstance(stream.listening.error, InputError)
    assert [failure.listener for failure in stream.channel.failures] == ["the live analysis"]
    assert not _threads()


def test_a_run_that_fails_ends_it_at_once_without_a_polished_image() -> None:
    stream = Stream(LiveAnalysis(PLAN))
    stream.send(next(blocks(run().values, [60])))
    stream.end(FinishedEvent(outcome="failed", error="no board"))
    assert not any(event.final for event in stream.tracked)
    assert stream.listening.error is None
    assert not _threads()


def test_the_recording_is_the_same_with_and_without_it(tmp_path: Path) -> None:
    """A seeded bench on virtual time, much faster than real: images are skipped, values are not touched."""
    bench = bench_toml(
        tmp_path, 'object = "letter-B"\nobject_height_px = 10\nnoise = { kind = "pixel", sigma = 0.1, seed = 3 }'
    )
    plan: Plan = SMALL.model_copy(update={"frames": 300, "motion": None})
    with Instrument.from_toml(bench) as instrument:
        instrument.run(plan, tmp_path / "alone.h5")
    heard: list[Event] = []
    with Instrument.from_toml(bench) as instrument:
        watched_run = instrument.start(plan, tmp_path / "live.h5", listeners=[LiveAnalysis(plan), heard.append])
        watched_run.wait()
        assert watched_run.wait_for_listeners(30)
    assert watched_run.snapshot.listener_failures == ()
    last = [event for event in heard if isinstance(event, TrackingEvent)][-1]
    assert last.final
    assert last.frame == 300
    alone, watched = open_recording(tmp_path / "alone.h5"), open_recording(tmp_path / "live.h5")
    assert alone.timing == watched.timing
    assert np.array_equal(alone.values, watched.values)
    assert np.array_equal(alone.frame_valid, watched.frame_valid)
    assert alone.edge_time_s is not None
    assert watched.edge_time_s is not None
    assert np.array_equal(alone.edge_time_s, watched.edge_time_s)
