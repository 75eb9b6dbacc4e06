"""Recording to figures: motion, image, and how good both are."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from instrument.analysis.figures import Figures, figures_of
from instrument.analysis.joint import refine
from instrument.reconstruction import Method, Reconstruction, reconstruct
from instrument.recording import Recording
from instrument.tracking import Trajectory, track
from protocols import Floats

Tracking: TypeAlias = Literal["joint", "smooth", "per-frame"]
"""``joint``: motion and image refined together; ``smooth``: one pass over all frames; ``per-frame``: the paper's."""

OnStep: TypeAlias = Callable[[str, int, int], None]
"""Told of what is being done, how many steps are done, and how many there are."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """All that is known of a recording after its analysis."""

    recording: Recording
    """What was analysed."""

    tracking: Tracking
    """How the motion was found."""

    trajectory: Trajectory
    """The motion."""

    reconstruction: Reconstruction
    """The image with the motion taken back."""

    ignored: Floats
    """``(m, m)``: the image as it comes out if the motion is ignored, for comparison."""

    figures: Figures
    """Figures of merit."""

    @property
    def image(self) -> Floats:
        """``(m, m)``: the image at frame 0, row = y (down), column = x."""
        return self.reconstruction.image

    @staticmethod
    def padded(rows: Floats, frames: int) -> Floats:
        """Rows of the frames analysed, with NaN for frames of the recording that were left out at its end."""
        return np.pad(rows, ((0, frames - len(rows)), (0, 0)), constant_values=np.nan)


def _tell_nobody(what: str, done: int, total: int) -> None:
    """Take no notice of progress."""


def analyse(
    recording: Recording,
    *,
    tracking: Tracking = "joint",
    method: Method = "tv",
    on_step: OnStep | None = None,
) -> Analysis:
    """Track the object, reconstruct its image, and judge both.

    Args:
        recording: whole or partial.
        tracking: how the motion is found.
        method: how the image is made.
        on_step: told of progress.

    Raises:
        InputError: no usable frame, or an object that leaves the field.
    """
    tell: OnStep = on_step or _tell_nobody
    started_s = time.perf_counter()
    tell("following the object", 0, 3)
    trajectory = track(recording, "per-frame" if tracking == "per-frame" else "smooth")
    tell("reconstructing", 1, 3)
    reconstruction: Reconstruction | None = None
    if tracking == "joint":
        refined = refine(recording, trajectory)
        trajectory, reconstruction = refined.trajectory, refined.image
    if reconstruction is None or method != "tv":
        reconstruction = reconstruct(recording, trajectory, method)
    took_s = time.perf_counter() - started_s
    tell("comparing", 2, 3)
    ignored = reconstruct(recording, np.zeros((len(recording), 2)), "conventional").image
    figures = figures_of(recording, trajectory, reconstruction, took_s)
    tell("done", 3, 3)
    return Analysis(recording, tracking, trajectory, reconstruction, ignored, figures)
