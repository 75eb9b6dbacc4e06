"""Where the object was, how surely, and at any time."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy.interpolate import CubicHermiteSpline

from protocols import Floats, InputError, Mask


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Displacement of every frame. As an array it is ``displacement_px``."""

    displacement_px: Floats
    """``(frames, 2)``: x, y in the middle of each frame, relative to frame 0."""

    sigma_px: Floats
    """``(frames, 2)``: one standard deviation of that; 0 at frame 0, infinite where nothing is known."""

    frame_time_s: float
    """From one frame to the next; frame k's middle is at (k + 1/2) of it, counted from the first edge."""

    method: str
    """How it was found: ``per-frame``, ``smooth``, ..."""

    valid: Mask
    """``(frames,)``: whether the frame was measured; the displacement of another frame is interpolated."""

    def __len__(self) -> int:
        """Frames."""
        return len(self.displacement_px)

    @property
    def time_s(self) -> Floats:
        """``(frames,)``: middle of each frame, from the first edge on."""
        return (np.arange(len(self), dtype=np.float64) + 0.5) * self.frame_time_s

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:  # noqa: FBT001  (numpy's own signature)
        """Give ``displacement_px``, as numpy asks for it."""
        return np.array(self.displacement_px, dtype=dtype, copy=copy)

    def at(self, time_s: Floats) -> Floats:
        """Displacement at any time of the run, such as each pattern's own.

        Between the middles of frames it is a cubic with the local velocity (central differences) at both; before the first
        and after the last middle that velocity goes on.

        Args:
            time_s: ``(...)``: seconds from the first edge on, as ``Recording.pattern_time_s``.

        Returns:
            ``(..., 2)``: x, y in px.
        """
        middle_s = self.time_s
        inside_s = np.clip(time_s, middle_s[0], middle_s[-1])
        outside_s = np.asarray(time_s - inside_s)[..., None]
        start, end = self._velocity_px_s[0], self._velocity_px_s[-1]
        if len(self) == 1:
            return np.broadcast_to(self.displacement_px[0], (*inside_s.shape, 2)).copy()
        curve = CubicHermiteSpline(middle_s, self.displacement_px, self._velocity_px_s)
        inside: Floats = np.asarray(curve(inside_s), np.float64)
        return inside + np.asarray(outside_s * np.where(outside_s < 0, start, end), np.float64)

    @cached_property
    def _velocity_px_s(self) -> Floats:
        """``(frames, 2)``."""
        if len(self) == 1:
            return np.zeros((1, 2))
        velocity: Floats = np.gradient(self.displacement_px, self.frame_time_s, axis=0)
        return velocity


def as_trajectory(motion: Trajectory | Floats | None, frames: int, frame_time_s: float) -> Trajectory:
    """Take displacements as they come: a trajectory, ``(frames, 2)`` px in the middle of each frame, or None for rest.

    Args:
        motion: displacements of one run.
        frames: of that run.
        frame_time_s: time from one frame to the next.

    Raises:
        InputError: not one finite displacement for each frame.
    """
    if isinstance(motion, Trajectory):
        trajectory = motion
    else:
        places = np.zeros((frames, 2)) if motion is None else np.asarray(motion, np.float64)
        trajectory = Trajectory(
            displacement_px=places,
            sigma_px=np.zeros_like(places),
            frame_time_s=frame_time_s,
            method="at rest" if motion is None else "given",
            valid=np.ones(len(places), np.bool_),
        )
    shape = trajectory.displacement_px.shape
    if shape != (frames, 2) or not np.isfinite(trajectory.displacement_px).all():
        raise InputError(
            saw=f"displacements of shape {shape}, {np.count_nonzero(~np.isfinite(trajectory.displacement_px))} not finite",
            expected=f"finite displacements of shape ({frames}, 2): x, y of each recorded frame",
            remedy="pass the trajectory that track() gives for this recording",
        )
    return trajectory
