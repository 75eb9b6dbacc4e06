"""The live analysis without its thread: it takes blocks, gives motion and images, and can be stepped by hand."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from pydantic import NonNegativeInt

from instrument.acquisition import AlignedBlock
from instrument.live.frames import FrameAssembler
from instrument.live.imager import ProgressiveImager
from instrument.measurement import IDEAL, LightModel, LightStream
from instrument.plan import Plan
from instrument.schemes import scheme_of
from instrument.tracking import StreamingTracker
from protocols import Floats, Frozen

IMAGE_INTERVAL_S: Final = 0.019
"""Stream time from one image to the next: slightly more than 50 images a second."""


class LiveCounters(Frozen):
    """Numbers of frames and images, those that were left out included."""

    frames: NonNegativeInt = 0
    """Frames tracked, those without values included."""

    frames_dropped: NonNegativeInt = 0
    """Frames, counted in ``frames``, that the live view lost because it was late. The recording has them."""

    images: NonNegativeInt = 0
    """Images made while the stream went on, without the polished one."""

    images_skipped: NonNegativeInt = 0
    """Images that were due and were not made, because newer data had come or there were too few frames."""


@dataclass(frozen=True, eq=False)
class LiveUpdate:
    """What is new since the last update."""

    frame: int
    """Frames tracked so far; the newest one has the index ``frame - 1``."""

    displacement_px: Floats
    """``(n, 2)`` x, y of the newest n frames, relative to frame 0, as known when they came; n may be 0, and is where the scheme
    sees no position."""

    sigma_px: Floats
    """As ``displacement_px``: its standard uncertainty, as ``StreamingTracker`` states it; NaN where none is known."""

    image: Floats | None
    """``(m, m)``: row = y (down), column = x, in values for one lit pixel; None before the first image."""

    counters: LiveCounters
    """Numbers of frames and images so far."""

    final: bool = False
    """Whether this is the last update, with the polished image of the whole run."""


class LiveLine:
    """Tracks the object in every frame it is given, and makes the images that are due if there is time for them.

    Where the scheme has no position, the object is taken as at rest; where it has no image, none is made.

    One image is due for each ``image_interval_s`` of stream. Images that are still due when newer data come are skipped and
    counted: ``images + images_skipped + images_due`` is the number of images that were due so far.
    """

    def __init__(
        self,
        plan: Plan,
        *,
        light: LightModel = IDEAL,
        image_interval_s: float = IMAGE_INTERVAL_S,
        max_rows: int | None = None,
    ) -> None:
        """Prepare for one run.

        Args:
            plan: plan of the run.
            light: what an earlier analysis found that the bench does to the light.
            image_interval_s: stream time from one image to the next; at least one frame is taken.
            max_rows: number of patterns kept for the image, as in ``ProgressiveImager``.
        """
        scheme = scheme_of(plan)
        self._frames = FrameAssembler(plan.patterns_per_frame)
        self._tracker = StreamingTracker(plan) if scheme.position is not None else None
        self._light = LightStream(scheme, light)
        loss = light.edge_loss.value / plan.superpixel
        imaging = scheme.image_rows is not None
        self._imager = ProgressiveImager(plan, max_rows=max_rows, edge_loss_a_side=loss) if imaging else None
        self._followed = 0
        self._frames_an_image = max(1, round(image_interval_s / plan.frame_time_s))
        self._new_px: list[Floats] = []
        self._new_sigma_px: list[Floats] = []
        self._run_frames = plan.frames
        self._due = 0
        self._images = 0
        self._skipped = 0

    @property
    def images_due(self) -> int:
        """Number of images that are due now."""
        return 0 if self._imager is None else self._due

    @property
    def updates_due(self) -> int:
        """Number of updates that are due now: with an image each, where the scheme has one."""
        return self._due

    @property
    def complete(self) -> bool:
        """Whether all frames of the plan have come."""
        return self._followed >= self._run_frames

    @property
    def counters(self) -> LiveCounters:
        """Numbers of frames and images so far."""
        return LiveCounters(
            frames=self._followed,
            frames_dropped=self._frames.frames_dropped,
            images=self._images,
            images_skipped=self._skipped,
        )

    def take(self, blocks: Sequence[AlignedBlock]) -> None:
        """Track the object through all frames of these blocks."""
        before = self._followed
        for block in blocks:
            for arrived in self._frames.whole(block):
                values = self._light.take(arrived)
                displacement_px = np.zeros((len(values), 2)) if self._tracker is None else self._tracker.push(values)
                if self._imager is not None:
                    self._imager.add(values, displacement_px)
                self._followed += len(values)
                if self._tracker is not None:
                    self._new_px.append(displacement_px)
                    self._new_sigma_px.append(self._tracker.sigma_px)
        newly_due = self._followed // self._frames_an_image - before // self._frames_an_image
        if newly_due:
            self._skip_due()
            self._due = newly_due

    def improve(self, effort: float = 1.0) -> LiveUpdate:
        """Make one image that is due, or skip it where there are too few frames.

        Of a scheme that only tracks, the update holds the new displacements alone.

        Args:
            effort: factor on the time that the image takes.
        """
        self._due -= 1
        if self._imager is None:
            return self._update(None)
        image = self._imager.improve(effort=effort)
        if image is None:
            self._skipped += 1
        else:
            self._images += 1
        return self._update(image)

    def finish(self) -> LiveUpdate:
        """Skip the images that are still due, and polish the image of all frames kept."""
        self._skip_due()
        return self._update(None if self._imager is None else self._imager.polish(), final=True)

    def _skip_due(self) -> None:
        self._skipped += self.images_due
        self._due = 0

    def _update(self, image: Floats | None, *, final: bool = False) -> LiveUpdate:
        """Give what is new since the last update."""
        new_px, sigma_px = (
            np.concatenate(arrays) if arrays else np.zeros((0, 2)) for arrays in (self._new_px, self._new_sigma_px)
        )
        self._new_px.clear()
        self._new_sigma_px.clear()
        return LiveUpdate(self._followed, new_px, sigma_px, image, self.counters, final)
