"""The live analysis of a run, on a thread of its own."""

from collections.abc import Callable
from threading import Thread
from typing import Self

from instrument.acquisition import AlignedBlock
from instrument.live.blocks import BlockQueue
from instrument.live.line import IMAGE_INTERVAL_S, LiveCounters, LiveLine, LiveUpdate
from instrument.plan import Plan
from protocols import Clock, MonotonicClock

QUEUE_PATTERNS = 60_000  # three seconds at 20 kHz, half a megabyte
_BUSY = 0.8  # of the time between images that making one may take
_EFFORTS = (0.5, 3.0)


class LiveAnalysis:
    """Looks on while a run goes on: ``Instrument.run(plan, on_block=live.on_block)``.

    A context manager. Inside, a thread follows the object and improves its image; leaving it ends the thread, after the polished
    image of the whole run, or at once where the run failed. The run never waits for it and never fails because of it: an error in
    here, or in ``on_update``, ends the live analysis alone and is found in ``error``.
    """

    def __init__(
        self,
        plan: Plan,
        on_update: Callable[[LiveUpdate], None],
        *,
        image_interval_s: float = IMAGE_INTERVAL_S,
        max_rows: int | None = None,
        queue_patterns: int = QUEUE_PATTERNS,
        clock: Clock | None = None,
    ) -> None:
        """Prepare for one run.

        Args:
            plan: what is shown.
            on_update: told of each image, on the thread of the analysis.
            image_interval_s: stream time from image to image.
            max_rows: frames kept for the image, as in ``ProgressiveImager``.
            queue_patterns: how many patterns may wait; beyond, the oldest blocks are dropped.
            clock: by which the effort for an image is kept below the interval; None takes the host's, on which the work is done.
        """
        self._line = LiveLine(plan, image_interval_s=image_interval_s, max_rows=max_rows)
        self._queue = BlockQueue(queue_patterns)
        self._on_update = on_update
        self._interval_s = image_interval_s
        self._clock = clock or MonotonicClock()
        self._effort = 1.0
        self._error: Exception | None = None
        self._abandoned = False
        self._thread = Thread(target=self._work, name="kinopix-live", daemon=True)

    @property
    def error(self) -> Exception | None:
        """What ended the analysis early; None where nothing did."""
        return self._error

    @property
    def effort(self) -> float:
        """How much is spent on an image now, 1 being a burst of 10 to 15 ms on one core."""
        return self._effort

    @property
    def counters(self) -> LiveCounters:
        """What was done so far."""
        return self._line.counters

    @property
    def blocks_dropped(self) -> int:
        """Blocks that were thrown away because the analysis was late."""
        return self._queue.blocks_dropped

    def on_block(self, block: AlignedBlock) -> None:
        """Copy a block into the queue and return at once. For the acquisition's thread."""
        self._queue.put(block)

    def close(self, *, abandon: bool = False) -> None:
        """End the thread and wait for its end; a second time does nothing.

        Args:
            abandon: leave out what still waits, and the polished image.
        """
        self._abandoned = self._abandoned or abandon
        self._queue.close(forget=abandon)
        if self._thread.ident is not None:
            self._thread.join()

    def __enter__(self) -> Self:
        """Start the thread."""
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *exc: object) -> None:
        """End the thread."""
        self.close(abandon=kind is not None)

    def _work(self) -> None:
        line, queue = self._line, self._queue
        try:
            while not line.complete and (blocks := queue.take(wait=not line.images_due)) is not None:
                line.take(blocks)
                if line.images_due and not line.complete:
                    self._make_image()
            if not self._abandoned:
                self._on_update(line.finish())
        except Exception as error:  # noqa: BLE001  (whatever it is, the run goes on and the caller is told)
            self._error = error
        finally:
            queue.close(forget=True)

    def _make_image(self) -> None:
        """Spend as much on an image as lets the next one be in time on this machine."""
        start_s = self._clock.now_s()
        update = self._line.improve(self._effort)
        took_s = max(self._clock.now_s() - start_s, 1e-6)
        least, most = _EFFORTS
        self._effort = min(max(self._effort * (_BUSY * self._interval_s / took_s) ** 0.5, least), most)
        self._on_update(update)
