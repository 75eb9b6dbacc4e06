"""The live analysis on its thread, beside a run."""

from pathlib import Path
from threading import Event, current_thread
from threading import enumerate as all_threads

import numpy as np
import pytest

from instrument.instrument import Instrument
from instrument.live import LiveAnalysis, LiveUpdate
from instrument.plan import Plan
from instrument.storage import open_recording
from instrument.tracking import StreamingTracker
from protocols import DeviceDisconnected
from tests.instrument.live.streams import FRAMES, PLAN, blocks, psnr, run
from tests.support.benches import SMALL, bench_toml


def _threads() -> list[str]:
    return [thread.name for thread in all_threads() if thread.name == "kinopix-live"]


def test_it_follows_every_frame_and_ends_with_the_polished_image() -> None:
    recording = run()
    assert recording.truth is not None
    updates: list[LiveUpdate] = []
    with LiveAnalysis(PLAN, updates.append) as live:
        for piece in blocks(recording.values, [250]):
            live.on_block(piece)
    assert live.error is None
    followed = np.concatenate([update.displacement_px for update in updates])
    assert np.array_equal(followed, StreamingTracker(PLAN).push(recording.values))
    assert [update.final for update in updates] == [False] * (len(updates) - 1) + [True]
    last = updates[-1]
    assert last.image is not None
    assert psnr(last.image, recording.truth.image) > 30
    assert (live.counters.frames, live.counters.frames_dropped, live.blocks_dropped) == (FRAMES, 0, 0)
    # One image is due every 63 frames (18.9 ms): nine in 600.
    assert live.counters.images + live.counters.images_skipped == 9
    assert not _threads()


def test_while_it_is_busy_the_queue_fills_drops_its_oldest_and_counts_them() -> None:
    """Frames 0 to 99 keep it busy; then five blocks of 100 frames come into room for two."""
    busy, go_on = Event(), Event()
    updates: list[LiveUpdate] = []

    def on_update(update: LiveUpdate) -> None:
        updates.append(update)
        busy.set()
        assert go_on.wait(10)

    with LiveAnalysis(PLAN, on_update, queue_patterns=1200) as live:
        pieces = list(blocks(run().values, [600]))
        live.on_block(pieces[0])
        assert busy.wait(10)
        for piece in pieces[1:]:
            live.on_block(piece)  # returns, although nobody takes anything
        assert live.blocks_dropped == 3
        go_on.set()
    assert live.error is None
    assert (live.counters.frames, live.counters.frames_dropped) == (FRAMES, 300)
    assert updates[-1].final


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
    made: list[LiveUpdate] = []
    one_at_a_time = Event()

    def on_update(update: LiveUpdate) -> None:
        made.append(update)
        one_at_a_time.set()

    with LiveAnalysis(PLAN, on_update, clock=_SlowClock()) as live:
        for piece in blocks(run().values[:378], [378]):
            one_at_a_time.clear()
            live.on_block(piece)
            assert one_at_a_time.wait(10)
        assert live.effort == 0.5
    assert live.error is None
    assert made[-1].final


def test_an_error_of_its_own_is_reported_and_nothing_else_happens() -> None:
    failed_on: list[str] = []

    def on_update(update: LiveUpdate) -> None:
        failed_on.append(current_thread().name)
        raise ZeroDivisionError("the page went away")

    with LiveAnalysis(PLAN, on_update) as live:
        for piece in blocks(run().values, [600]):
            live.on_block(piece)
    assert isinstance(live.error, ZeroDivisionError)
    assert failed_on == ["kinopix-live"]
    assert not _threads()
    live.on_block(next(blocks(run().values, [600])))
    live.close()


def test_a_run_that_fails_ends_it_at_once_without_a_polished_image() -> None:
    updates: list[LiveUpdate] = []
    lost = DeviceDisconnected(device="pmt", saw="no board", expected="one", remedy="check the cable")
    live = LiveAnalysis(PLAN, updates.append)

    def failing_run() -> None:
        with live:
            live.on_block(next(blocks(run().values, [60])))
            raise lost

    with pytest.raises(DeviceDisconnected):
        failing_run()
    assert not any(update.final for update in updates)
    assert live.error is None
    assert not _threads()


def test_the_recording_is_the_same_with_and_without_it(tmp_path: Path) -> None:
    """A seeded bench on virtual time, much faster than real: images are skipped, values are not touched."""
    bench = bench_toml(
        tmp_path, 'object = "letter-B"\nobject_height_px = 10\nnoise = { kind = "pixel", sigma = 0.1, seed = 3 }'
    )
    plan: Plan = SMALL.model_copy(update={"frames": 300, "motion": None})
    with Instrument.from_toml(bench) as instrument:
        instrument.run(plan, tmp_path / "alone.h5")
    updates: list[LiveUpdate] = []
    with Instrument.from_toml(bench) as instrument, LiveAnalysis(plan, updates.append) as live:
        instrument.run(plan, tmp_path / "live.h5", on_block=live.on_block)
    assert live.error is None
    assert updates[-1].final
    assert updates[-1].frame == 300
    alone, watched = open_recording(tmp_path / "alone.h5"), open_recording(tmp_path / "live.h5")
    assert alone.timing == watched.timing
    assert np.array_equal(alone.values, watched.values)
    assert np.array_equal(alone.frame_valid, watched.frame_valid)
    assert alone.edge_time_s is not None
    assert watched.edge_time_s is not None
    assert np.array_equal(alone.edge_time_s, watched.edge_time_s)
