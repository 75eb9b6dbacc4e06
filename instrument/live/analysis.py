"""The live analysis of a run: a listener that tells what it finds."""

from typing import Final

from instrument.live.line import IMAGE_INTERVAL_S, LiveCounters, LiveLine, LiveUpdate
from instrument.measurement import IDEAL, LightModel
from instrument.plan import Plan
from instrument.session import BlockEvent, Feed, FinishedEvent, ImageEvent, Publish, TrackingEvent
from protocols import Clock, MonotonicClock

_BUSY: Final = 0.8  # of the time between images that making one may take
_EFFORTS: Final = (0.5, 3.0)


class LiveAnalysis:
    """Looks on while a run goes on: ``Instrument.run(plan, listeners=[LiveAnalysis(plan), ...])``.

    A ``Follower``: it takes blocks when it has time, follows the object and improves its image, and publishes ``TrackingEvent``
    and ``ImageEvent`` to all other listeners. The last ones, ``final``, hold the polished image of the whole run; there are none
    where the run failed. The run never waits for it and never fails because of it.
    """

    name: Final = "the live analysis"

    def __init__(
        self,
        plan: Plan,
        *,
        light: LightModel = IDEAL,
        image_interval_s: float = IMAGE_INTERVAL_S,
        max_rows: int | None = None,
        clock: Clock | None = None,
    ) -> None:
        """Prepare for one run.

        Args:
            plan: what is shown.
            light: what an earlier analysis found that the bench does to the light; see ``analysis.light_found``.
            image_interval_s: stream time from image to image.
            max_rows: frames kept for the image, as in ``ProgressiveImager``.
            clock: by which the effort for an image is kept below the interval; None takes the host's, on which the work is done.
        """
        self._line = LiveLine(plan, light=light, image_interval_s=image_interval_s, max_rows=max_rows)
        self._interval_s = image_interval_s
        self._clock = clock or MonotonicClock()
        self._effort = 1.0

    @property
    def effort(self) -> float:
        """How much is spent on an image now, 1 being a burst of 10 to 15 ms on one core."""
        return self._effort

    @property
    def counters(self) -> LiveCounters:
        """What was done so far."""
        return self._line.counters

    def follow(self, feed: Feed, publish: Publish) -> None:
        """Take blocks until the run is over, and publish what they show."""
        line, over = self._line, False
        while not (over or line.complete) and (events := feed.take(wait=not line.updates_due)) is not None:
            line.take([event.block for event in events if isinstance(event, BlockEvent) and event.block is not None])
            ends = [event for event in events if isinstance(event, FinishedEvent)]
            if any(end.outcome != "done" for end in ends):
                return
            over = bool(ends)
            if line.updates_due and not (over or line.complete):
                self._make_image(publish)
        publish_update(line.finish(), publish)

    def _make_image(self, publish: Publish) -> None:
        """Spend as much on an image as lets the next one be in time on this machine."""
        start_s = self._clock.now_s()
        update = self._line.improve(self._effort)
        took_s = max(self._clock.now_s() - start_s, 1e-6)
        least, most = _EFFORTS
        self._effort = min(max(self._effort * (_BUSY * self._interval_s / took_s) ** 0.5, least), most)
        publish_update(update, publish)


def publish_update(update: LiveUpdate, publish: Publish) -> None:
    """Publish an update: its image, then the figures."""
    if update.image is not None:
        publish(ImageEvent(frame=update.frame, image=update.image, final=update.final))
    publish(
        TrackingEvent(
            frame=update.frame,
            displacement_px=update.displacement_px,
            sigma_px=update.sigma_px,
            frames_dropped=update.counters.frames_dropped,
            images=update.counters.images,
            images_skipped=update.counters.images_skipped,
            final=update.final,
        )
    )
