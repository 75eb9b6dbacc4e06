"""The live analysis stepped in one thread: its effort by a clock that is written down, and what it publishes."""

from collections.abc import Iterator

import numpy as np
import pytest

from instrument.live import LiveAnalysis, LiveCounters, LiveUpdate, ProgressiveImager
from instrument.live.analysis import publish_update
from instrument.session import BlockEvent, Event, Feed, FinishedEvent, ImageEvent, TrackingEvent
from protocols import Floats
from tests.instrument.live.streams import PLAN, block, run

INTERVAL_S = 60 * PLAN.frame_time_s
EACH = 360
"""Patterns from image to image."""


class _Written:
    """A clock that is looked at before and after each image, which takes as long as is written down."""

    def __init__(self, took_s: list[float]) -> None:
        self._looks: Iterator[float] = iter([look for took in took_s for look in (100.0, 100.0 + took)])

    def now_s(self) -> float:
        return next(self._looks)

    def sleep_s(self, duration_s: float) -> None:
        raise AssertionError(f"nothing may wait, {duration_s} s here")


def _followed(live: LiveAnalysis, pieces: int, end: FinishedEvent | None = None) -> list[Event]:
    """Give what it publishes when each piece comes after the image of the one before, and then the end."""
    feed, told = Feed(), list[Event]()
    coming = iter(np.split(run().values.ravel()[: pieces * EACH], pieces))

    def bring(first: int) -> None:
        values = next(coming, None)
        if values is not None:
            feed.put(BlockEvent.of(block(first, values)))
        else:
            if end is not None:
                feed.put(end)
            feed.close()

    def publish(event: Event) -> None:
        told.append(event)
        if isinstance(event, TrackingEvent) and not event.final:
            bring(event.frame * PLAN.patterns_per_frame)

    bring(0)
    live.follow(feed, publish)
    return told


@pytest.mark.parametrize(
    ("shares", "effort"),
    [
        pytest.param([0.8], 1.0, id="four fifths of the interval are as wanted"),
        pytest.param([0.4], 2**0.5, id="half as long: the root of two"),
        pytest.param([1.6], 0.5**0.5, id="twice as long: its inverse"),
        pytest.param([0.4, 0.4], 2.0, id="twice half as long"),
        pytest.param([0.8 / 16], 3.0, id="at most three"),
        pytest.param([80.0], 0.5, id="at least a half"),
        pytest.param([80.0, 0.2], 1.0, id="from a half up again by two"),
        pytest.param([0.0], 3.0, id="a clock that stands still"),
    ],
)
def test_the_effort_goes_with_the_root_of_the_time_that_there_would_be(shares: list[float], effort: float) -> None:
    live = LiveAnalysis(PLAN, image_interval_s=INTERVAL_S, clock=_Written([share * INTERVAL_S for share in shares]))
    assert live.effort == 1.0
    told = _followed(live, len(shares))
    assert live.effort == pytest.approx(effort)
    assert [
        (event.kind, event.frame, event.final) for event in told if isinstance(event, ImageEvent | TrackingEvent)
    ] == [
        *[(kind, 60 * (k + 1), False) for k in range(len(shares)) for kind in ("image", "tracking")],
        ("image", 60 * len(shares), True),
        ("tracking", 60 * len(shares), True),
    ]
    assert live.counters == LiveCounters(frames=60 * len(shares), images=len(shares))


@pytest.mark.parametrize(("outcome", "finals"), [("done", 2), ("failed", 0), ("aborted", 0)])
def test_only_a_run_that_is_done_has_a_last_image(outcome: str, finals: int) -> None:
    end = FinishedEvent.model_validate({"outcome": outcome})
    told = _followed(LiveAnalysis(PLAN, image_interval_s=INTERVAL_S), 1, end)
    assert sum(event.final for event in told if isinstance(event, ImageEvent | TrackingEvent)) == finals
    assert len(told) == 2 + finals


def test_an_update_is_published_image_first_with_its_own_figures() -> None:
    told = list[Event]()
    way, image = np.array([[1.0, 2.0], [3.0, 4.0]]), np.eye(3)
    counters = LiveCounters(frames=9, frames_dropped=4, images=3, images_skipped=2)
    publish_update(LiveUpdate(9, way, way / 8, image, counters, final=True), told.append)
    publish_update(LiveUpdate(10, way[:0], way[:0], None, counters), told.append)
    first, second, third = told
    assert isinstance(first, ImageEvent)
    assert (first.frame, first.final, first.image.tolist()) == (9, True, image.tolist())
    assert isinstance(second, TrackingEvent)
    assert (second.frame, second.frames_dropped, second.images, second.images_skipped) == (9, 4, 3, 2)
    assert (second.final, second.displacement_px.tolist()) == (True, way.tolist())
    assert isinstance(third, TrackingEvent)
    assert (third.frame, third.final, third.displacement_px.shape) == (10, False, (0, 2))


def _image(values: Floats) -> tuple[Floats, ProgressiveImager]:
    recording = run()
    assert recording.truth is not None
    imager = ProgressiveImager(PLAN, max_rows=250)
    imager.add(values, recording.truth.displacement_px)
    image = imager.improve(40)
    assert image is not None
    return image, imager


def test_a_lamp_four_times_as_bright_gives_an_image_four_times_as_bright() -> None:
    """A power of two changes no digit but for the solver's smallest divisors."""
    dim, one = _image(run().values)
    bright, other = _image(4 * run().values)
    np.testing.assert_allclose(bright, 4 * dim, atol=4e-3)
    assert other.misfit == pytest.approx(one.misfit, rel=1e-3)


def test_what_is_kept_between_bursts_is_nine_pictures_of_the_region_and_its_eigenvector() -> None:
    """An image, a dual variable of 2 x 4 of them and an eigenvector, in singles, beside the frames."""
    _, imager = _image(run().values)
    pixels = imager.region.height * imager.region.width
    assert imager.nbytes == 250 * 8 * (2 + 1 + 6 + 4) + 4 * pixels * (1 + 8 + 1)
    assert imager.region.shape != (PLAN.image_size, PLAN.image_size)


@pytest.mark.parametrize(("size", "rows"), [(64, 512), (32, 128), (16, 32), (8, 16)])
def test_an_eighth_of_all_patterns_is_kept_but_never_fewer_than_sixteen(size: int, rows: int) -> None:
    imager = ProgressiveImager(PLAN.model_copy(update={"image_size": size}))
    imager.add(np.ones((600, 6)), np.zeros((600, 2)))
    assert (imager.frames, imager.rows) == (600, rows)
