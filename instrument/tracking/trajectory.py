"""The displacement of an object over a run, with its uncertainty, at any time."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy.interpolate import CubicHermiteSpline

from instrument.config import DisplacementSection
from instrument.frame_times import frame_middle_s
from instrument.shown import card, curves, line
from instrument.tables import data_frame
from instrument.tracking.covariance import PathCovariance
from instrument.tracking.kinematics import MotionFit, in_mm, motion_fit, require_scale
from protocols import Floats, InputError, Mask
from protocols.field_docs import with_fields


@with_fields
@dataclass(frozen=True, eq=False)
class Trajectory:
    """Displacement of every frame. ``numpy.asarray`` gives ``displacement_px``."""

    displacement_px: Floats
    """``(frames, 2)``: x, y in the middle of each frame, relative to ``reference_frame``."""

    sigma_px: Floats
    """``(frames, 2)``: standard deviation of ``displacement_px``; 0 at ``reference_frame``, infinite where nothing is known."""

    frame_time_s: float
    """Time from one frame to the next. The middle of frame k is k + 1/2 of it after the first edge."""

    method: str
    """Name of the method that found it: ``per-frame``, ``smooth``, ``joint``, ``given`` or ``at rest``."""

    valid: Mask
    """``(frames,)``: whether the frame was measured; the displacement of the others is interpolated."""

    angle_deg: Floats | None = None
    """``(frames,)``: angle by which the object has turned since ``reference_frame``, from x to y, clockwise as one looks at the
    picture; the displacement is then that of its centroid. None where the scheme sees no angle, and the object was not found to
    turn."""

    angle_sigma_deg: Floats | None = None
    """``(frames,)``: standard deviation of ``angle_deg``."""

    magnification: Floats | None = None
    """``(frames,)``: size of the object over that at ``reference_frame``; None where it was not found to change."""

    magnification_sigma: Floats | None = None
    """``(frames,)``: standard deviation of ``magnification``."""

    pivot_px: Floats | None = None
    """``(2,)``: x, y at ``reference_frame`` of the point whose displacement is given, about which the object turns and grows, in
    px of the field; None where it does neither."""

    start_px: Floats | None = None
    """``(2,)``: x, y of the object's centroid at frame 0, in px of the field, whose first pixel has its middle at 0; None where
    the scheme measures displacement alone."""

    start_sigma_px: Floats | None = None
    """``(2,)``: standard deviation of ``start_px``."""
    covariance: PathCovariance | None = None
    """How its errors hang together; None for a path that was not smoothed, or of few frames."""

    reference_frame: int = 0
    """Frame that displacements are relative to, and whose image is shown: the first one, but of an object that comes into the
    field the first in which all of it is inside, and of a run that begins in the dark the first that was measured."""

    scale: DisplacementSection | None = None
    """Pixels a millimetre and axis of the bench that it was recorded on; None where it was not calibrated."""

    @property
    def displacement_mm(self) -> Floats:
        """``(frames, 2)``: displacement along the stage's axis, and across it, in mm.

        Raises:
            InputError: the bench was not calibrated.
        """
        return in_mm(self, require_scale(self.scale))[0]

    @property
    def sigma_mm(self) -> Floats:
        """``(frames, 2)``: standard uncertainty of ``displacement_mm``, that of the calibration included.

        Raises:
            InputError: the bench was not calibrated.
        """
        return in_mm(self, require_scale(self.scale))[1]

    @property
    def motion_px(self) -> MotionFit | None:
        """Travel, speed and acceleration in px; None where the path does not know its covariance."""
        return motion_fit(self)

    @property
    def motion_mm(self) -> MotionFit | None:
        """Travel, speed and acceleration in mm along the stage's axis; None as in px, or where the bench was not calibrated."""
        return None if self.scale is None else motion_fit(self, self.scale)

    @property
    def last_known(self) -> int:
        """The last frame in which the displacement is known; the last one of all where it is known of one frame at most."""
        known = np.flatnonzero(np.isfinite(self.sigma_px).all(axis=1))
        return int(known[-1]) if len(known) > 1 else len(self) - 1

    def __len__(self) -> int:
        """Give the number of frames."""
        return len(self.displacement_px)

    @property
    def time_s(self) -> Floats:
        """``(frames,)``: time of the middle of each frame after the first edge."""
        return frame_middle_s(len(self), self.frame_time_s)

    def __repr__(self) -> str:
        """Say in one line where it leads."""
        return line("Trajectory", *self._facts().values())

    def _repr_html_(self) -> str:
        """Show in a notebook where it leads, with its uncertainty."""
        drawn = curves(self.time_s, self.displacement_px, self.sigma_px, "displacement x, y", "px; x blue, y orange")
        return card("Trajectory", self._facts(), drawn)

    def _facts(self) -> dict[str, str]:
        end_px, known = self.displacement_px[self.last_known], self.sigma_px[np.isfinite(self.sigma_px)]
        facts = {
            "frames": f"{len(self)} frames in {len(self) * self.frame_time_s:.3g} s",
            "end": f"to x {end_px[0]:+.2f}, y {end_px[1]:+.2f} px",
            "uncertainty": f"known to {np.median(known):.3f} px (median)" if len(known) else "uncertainty not known",
            "method": self.method,
        }
        if self.scale is not None:
            facts["scale"] = f"{self.scale.px_per_mm:.4g} px/mm"
        return facts

    def to_dataframe(self) -> Any:
        """Give time, displacement and uncertainty of every frame as a ``pandas.DataFrame``, in mm too where the scale is known.

        Raises:
            InputError: pandas is not installed.
        """
        columns: dict[str, Floats | Mask] = {
            "time_s": self.time_s,
            "x_px": self.displacement_px[:, 0],
            "y_px": self.displacement_px[:, 1],
            "sigma_x_px": self.sigma_px[:, 0],
            "sigma_y_px": self.sigma_px[:, 1],
            "measured": self.valid,
        }
        if self.angle_deg is not None:
            columns["angle_deg"] = self.angle_deg
        if self.angle_sigma_deg is not None:
            columns["sigma_angle_deg"] = self.angle_sigma_deg
        if self.magnification is not None:
            columns["magnification"] = self.magnification
        if self.magnification_sigma is not None:
            columns["sigma_magnification"] = self.magnification_sigma
        if self.scale is not None:
            (along, across), (sigma_along, sigma_across) = self.displacement_mm.T, self.sigma_mm.T
            columns |= {"along_mm": along, "across_mm": across}
            columns |= {"sigma_along_mm": sigma_along, "sigma_across_mm": sigma_across}
        return data_frame(columns, "frame")

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:  # noqa: FBT001  (numpy's own signature)
        """Give ``displacement_px`` to numpy."""
        return np.array(self.displacement_px, dtype=dtype, copy=copy)

    def known_where(self, seen: Mask) -> "Trajectory":
        """Give the path with an infinite uncertainty before the object was first seen and after it was last seen.

        Args:
            seen: ``(frames,)``: frames in which it was seen; at least one.
        """
        used = np.flatnonzero(seen)
        first, end = min(int(used[0]), self.reference_frame), int(used[-1]) + 1
        sigma_px = self.sigma_px.copy()
        sigma_px[:first] = np.inf
        sigma_px[end:] = np.inf
        known = self.covariance
        if known is not None:
            count = int(np.count_nonzero(known.frame < end))
            kept = replace(known, frame=known.frame[:count], covariance_px2=known.covariance_px2[:, :count, :count])
            known = kept if count else None
        return replace(self, sigma_px=sigma_px, covariance=known)

    def at(self, time_s: Floats) -> Floats:
        """Give the displacement at any time of the run, such as that of each pattern.

        Between the middles of two frames it is a cubic that has the local velocity (central differences) at both. Before the
        first and after the last middle the velocity is constant.

        Args:
            time_s: ``(...)`` times after the first edge, as in ``Recording.pattern_time_s``.

        Returns:
            ``(..., 2)`` x and y in px.
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
        """``(frames, 2)``: velocity in the middle of each frame, x and y in px/s."""
        if len(self) == 1:
            return np.zeros((1, 2))
        velocity: Floats = np.gradient(self.displacement_px, self.frame_time_s, axis=0)
        return velocity


def as_trajectory(motion: Trajectory | Floats | None, frames: int, frame_time_s: float) -> Trajectory:
    """Give displacements as a trajectory.

    Args:
        motion: a trajectory, ``(frames, 2)`` displacements in px in the middle of each frame, or None for an object at rest.
        frames: number of frames of the run.
        frame_time_s: time from one frame to the next.

    Raises:
        InputError: there is not one finite displacement for each frame.
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
