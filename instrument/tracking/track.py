"""The one way from a recording to a trajectory."""

from typing import Literal

from instrument.recording import Recording
from instrument.tracking.per_frame import track_per_frame
from instrument.tracking.smooth import track_smooth
from instrument.tracking.trajectory import Trajectory


def track(
    recording: Recording,
    method: Literal["smooth", "per-frame"] = "smooth",
    *,
    reference_frames: int = 1,
    mean_filter: int = 1,
) -> Trajectory:
    """Find the object's displacement in every frame.

    A stationary background is taken off before: ``track(recording.minus(background))``.

    Args:
        recording: of the six-pattern scheme.
        method: ``smooth``, the best use of all frames together; ``per-frame``, the paper's: each frame by itself.
        reference_frames: ``per-frame`` only: frames at rest at the start that make up the reference.
        mean_filter: ``per-frame`` only: how many neighbouring coefficients are averaged (the paper: 5).

    Raises:
        InputError: no usable frame, or settings that the method does not have.
    """
    if method == "per-frame":
        return track_per_frame(recording, reference_frames=reference_frames, mean_filter=mean_filter)
    return track_smooth(recording)
