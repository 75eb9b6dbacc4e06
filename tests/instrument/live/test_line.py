"""The live analysis, stepped by hand."""

import tracemalloc

import numpy as np
import pytest

from instrument.live import LiveCounters, LiveLine, LiveUpdate
from instrument.plan import Plan
from instrument.tracking import StreamingTracker
from protocols import Floats
from tests.instrument.live.streams import FRAMES, PLAN, block, blocks, psnr, run

INTERVAL_S = 60 * PLAN.frame_time_s
"""An image every 60 frames: 10 in the run."""


def _followed(sizes: list[int]) -> Floats:
    line = LiveLine(PLAN, image_interval_s=INTERVAL_S)
    for piece in blocks(run().values, sizes):
        line.take([piece])
    return line.finish().displacement_px


@pytest.mark.parametrize("sizes", [[6], [1, 2, 3, 5, 8, 13, 21], [1000], [3600], [7]])
def test_the_motion_does_not_depend_on_how_the_stream_is_cut(sizes: list[int]) -> None:
    assert np.array_equal(_followed(sizes), StreamingTracker(PLAN).push(run().values))


def _played(line: LiveLine, block_patterns: int, images_a_block: int) -> list[LiveUpdate]:
    """Blocks that leave time for so many images each."""
    updates: list[LiveUpdate] = []
    for piece in blocks(run().values, [block_patterns]):
        line.take([piece])
        updates += [line.improve() for _ in range(min(images_a_block, line.images_due))]
    return [*updates, line.finish()]


def test_with_time_enough_every_image_that_is_due_is_made() -> None:
    """3,600 patterns in blocks of 360: an image is due with each, and with the last one too."""
    line = LiveLine(PLAN, image_interval_s=INTERVAL_S)
    updates = _played(line, 360, 3)
    assert line.counters == LiveCounters(frames=FRAMES, images=10)
    assert line.complete
    assert [update.frame for update in updates] == [*range(60, 601, 60), 600]
    assert [update.final for update in updates] == [False] * 10 + [True]
    assert sum(len(update.displacement_px) for update in updates) == FRAMES


def test_a_late_imager_skips_images_but_no_frame() -> None:
    """Blocks of 1,080 patterns, three images due with each of the first three and one with the last, time for one each."""
    line = LiveLine(PLAN, image_interval_s=INTERVAL_S)
    updates = _played(line, 1080, 1)
    assert line.counters == LiveCounters(frames=FRAMES, images=4, images_skipped=6)
    assert np.array_equal(
        np.concatenate([update.displacement_px for update in updates]), StreamingTracker(PLAN).push(run().values)
    )


def test_time_between_blocks_is_used_for_the_images_that_are_due() -> None:
    line = LiveLine(PLAN, image_interval_s=INTERVAL_S)
    _played(line, 1080, 3)
    assert line.counters == LiveCounters(frames=FRAMES, images=10)


def test_an_image_of_too_few_frames_is_skipped_and_counted() -> None:
    """16 frames make an image: of one after each 6 frames, the first two are none."""
    line = LiveLine(PLAN, image_interval_s=6 * PLAN.frame_time_s)
    images: list[bool] = []
    for piece in blocks(run().values[:24], [36]):
        line.take([piece])
        images.append(line.improve().image is not None)
    assert images == [False, False, True, True]
    assert line.counters == LiveCounters(frames=24, images=2, images_skipped=2)


def test_lost_blocks_are_counted_in_frames_and_the_image_is_made_of_the_others() -> None:
    recording = run()
    assert recording.truth is not None
    line = LiveLine(PLAN, image_interval_s=INTERVAL_S)
    flat = recording.values.ravel()
    line.take([block(0, flat[:1203]), block(1497, flat[1497:])])  # frames 200 to 249, the first and the last in part
    last = line.finish()
    assert last.counters.frames_dropped == 50
    assert last.counters.frames == len(last.displacement_px) == FRAMES
    assert last.image is not None
    assert psnr(last.image, recording.truth.image) > 26


def test_a_run_that_ends_before_its_first_image_still_ends_well() -> None:
    last = LiveLine(PLAN).finish()
    assert last.final
    assert last.image is None
    assert last.displacement_px.shape == (0, 2)


def test_a_stream_of_100_000_frames_takes_no_more_memory_than_one_of_10_000() -> None:
    """An object at rest, an image every 10,000 frames; nothing but the line keeps anything."""
    plan = Plan(frames=100_000, image_size=32)
    frame = np.array([[30.0, 20.0, 25.0, 35.0, 28.0, 22.0]])
    piece = np.repeat(frame, 500, axis=0).ravel()
    line = LiveLine(plan, image_interval_s=10_000 * plan.frame_time_s)
    used: list[int] = []
    tracemalloc.start()
    for first in range(0, 600_000, len(piece)):
        line.take([block(first, piece)])
        if line.images_due:
            line.improve()
            used.append(tracemalloc.get_traced_memory()[0])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert line.counters == LiveCounters(frames=100_000, images=10)
    assert max(used) - used[0] < 90_000  # a byte for each frame; its values and its place would be 64
    assert peak < 12_000_000
