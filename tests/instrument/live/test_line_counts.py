"""How many images are due: whatever the stream and the time, each that was due is made, skipped, or due still."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument.live import LiveLine
from instrument.plan import Plan
from tests.instrument.live.streams import block

PLAN = Plan(frames=400, image_size=16)


@pytest.mark.parametrize(
    ("frames_an_interval", "frames_an_image"),
    [(0.01, 1), (1.4, 1), (1.6, 2), (9.0, 9)],
)
@settings(max_examples=25, deadline=None)
@given(sizes=st.lists(st.integers(1, 200), min_size=1, max_size=12), made=st.integers(0, 3))
def test_images_made_skipped_and_due_are_all_that_were_due(
    frames_an_interval: float, frames_an_image: int, sizes: list[int], made: int
) -> None:
    """In the dark no image can be made, and each that is asked for counts as skipped."""
    line = LiveLine(PLAN, image_interval_s=frames_an_interval * PLAN.frame_time_s)
    first = asked = 0
    for size in sizes:
        before = first // 6 // frames_an_image
        line.take([block(first, np.zeros(size))])
        first += size
        newly = first // 6 // frames_an_image - before
        assert line.images_due == line.updates_due
        if newly:
            assert line.images_due == newly
        for _ in range(min(made, line.images_due)):
            assert line.improve().image is None
            asked += 1
        counters = line.counters
        assert counters.frames == first // 6
        assert counters.images == 0
        assert counters.images_skipped + line.images_due == first // 6 // frames_an_image
        assert counters.images_skipped >= asked
        assert line.complete == (first // 6 >= 400)
    line.finish()
    assert line.images_due == 0
    assert line.counters.images_skipped == first // 6 // frames_an_image
