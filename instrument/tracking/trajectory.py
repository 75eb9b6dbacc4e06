"""Where the object was, how surely, and at any time."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy.interpolate import CubicHermiteSpline

from protocols import Floats, Mask


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
        middle_s = (np.arange(len(self)) + 0.5) * self.frame_time_s
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
