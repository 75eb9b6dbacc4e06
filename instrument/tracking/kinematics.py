"""Travel, speed and acceleration of a path, in px and, where the bench is calibrated, in mm, each with its uncertainty.

A parabola is fitted to the path by least squares, and the uncertainties follow from the covariance that the smoother gives the
path: its errors last for many frames, so that the scatter of the frames says nothing of them. In mm the scale's own uncertainty,
which all numbers of a run share, is added.
"""

from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from instrument.config import DisplacementSection
from instrument.numerics import coverage_factor
from protocols import Floats, Frozen, InputError

if TYPE_CHECKING:
    from instrument.tracking.trajectory import Trajectory

_FEWEST_FRAMES: Final = 7
"""Frames whose covariance is known below which no motion is fitted: those of a run of eight, of which one is the reference."""

LengthUnit: TypeAlias = Literal["px", "mm"]
"""Unit of length of a motion."""


class Quantity(Frozen):
    """A number with its uncertainty."""

    value: float
    """The number."""

    sigma: float
    """Its standard uncertainty."""

    low: float
    """Lower end of the interval that holds the truth with 95 %."""

    high: float
    """Upper end of it."""


class MotionFit(Frozen):
    """What a parabola says of a path. The direction is that of the travel from the first to the last frame."""

    unit: LengthUnit
    """Unit of length."""

    travel: Quantity
    """Distance from the frame that displacements are relative to, which is the first one of most runs, to the last one whose
    covariance is known, in that unit."""

    speed: Quantity
    """Speed in the middle between both frames, in the unit a second. It is also the mean speed."""

    start_speed: Quantity
    """Speed at that first frame."""

    end_speed: Quantity
    """Speed at that last frame."""

    acceleration: Quantity
    """Acceleration, in the unit a second squared."""

    off_axis_deg: Quantity | None
    """Angle from the stage's axis to the direction of travel, or to the opposite one where the object went back; None in px."""


def in_mm(trajectory: "Trajectory", scale: DisplacementSection) -> tuple[Floats, Floats]:
    """Give a path in mm of the stage: along its axis, and across it (from x towards y).

    Args:
        trajectory: the path.
        scale: calibration of the bench.

    Returns:
        Displacements ``(frames, 2)`` and their standard uncertainties ``(frames, 2)``, the scale's own included.
    """
    x, y = scale.axis
    turn = np.array([[x, -y], [y, x]])
    place_mm: Floats = trajectory.displacement_px @ turn / scale.px_per_mm
    variance = trajectory.sigma_px**2 @ turn**2 / scale.px_per_mm**2
    relative = scale.px_per_mm_sigma / scale.px_per_mm
    turned = np.deg2rad(scale.axis_angle_sigma_deg)
    variance = variance + place_mm**2 * relative**2 + place_mm[:, ::-1] ** 2 * turned**2
    return place_mm, np.sqrt(variance)


def motion_fit(trajectory: "Trajectory", scale: DisplacementSection | None = None) -> MotionFit | None:
    """Fit travel, speed and acceleration.

    Args:
        trajectory: the path.
        scale: calibration of the bench, for mm; None for px.

    Returns:
        The fit; None where the path does not know its covariance, as one of each frame by itself or of few frames.
    """
    known = trajectory.covariance
    if known is None or len(known.frame) < _FEWEST_FRAMES or not np.isfinite(known.covariance_px2).all():
        return None
    time_s = (known.frame - trajectory.reference_frame) * trajectory.frame_time_s
    place_px = trajectory.displacement_px[known.frame]
    length_s = float(time_s[-1])
    direction = _direction(place_px[-1], scale)
    along_px = place_px @ direction
    covariance = np.einsum("a,akl->kl", direction**2, known.covariance_px2)
    # d(t) - d(0) = v t + a t^2 / 2, by plain least squares.
    design = np.stack([time_s, time_s**2 / 2], axis=1)
    solve = np.linalg.pinv(design)
    fit, of_fit = solve @ along_px, solve @ covariance @ solve.T
    unit: LengthUnit = "px" if scale is None else "mm"
    per_unit = 1.0 if scale is None else scale.px_per_mm
    relative = 0.0 if scale is None else scale.px_per_mm_sigma / scale.px_per_mm
    freedom = None if scale is None else scale.degrees_of_freedom

    def quantity(weights: tuple[float, float]) -> Quantity:
        vector = np.array(weights)
        value = float(vector @ fit) / per_unit
        variance = float(vector @ of_fit @ vector) / per_unit**2
        return _quantity(value, float(np.sqrt(variance + (value * relative) ** 2)), freedom)

    travel = float(along_px[-1]) / per_unit
    of_travel = float(np.sqrt(float(covariance[-1, -1]) / per_unit**2 + (travel * relative) ** 2))
    return MotionFit(
        unit=unit,
        travel=_quantity(travel, of_travel, freedom),
        speed=quantity((1.0, length_s / 2)),
        start_speed=quantity((1.0, 0.0)),
        end_speed=quantity((1.0, length_s)),
        acceleration=quantity((0.0, 1.0)),
        off_axis_deg=None if scale is None else _off_axis(place_px[-1], known.covariance_px2[:, -1, -1], scale),
    )


def _direction(travel_px: Floats, scale: DisplacementSection | None) -> Floats:
    """``(2,)``: unit vector along which motion is told: the stage's axis, or the travel's own direction."""
    if scale is not None:
        return np.array(scale.axis)
    length = float(np.hypot(*travel_px))
    return travel_px / length if length > 0 else np.array([1.0, 0.0])


def _quantity(value: float, sigma: float, freedom: int | None) -> Quantity:
    reach = coverage_factor(freedom) * sigma
    return Quantity(value=value, sigma=sigma, low=value - reach, high=value + reach)


def _off_axis(travel_px: Floats, variance_px2: Floats, scale: DisplacementSection) -> Quantity | None:
    """Angle between travel and axis."""
    length = float(np.hypot(*travel_px))
    if length == 0:
        return None
    x, y = scale.axis
    along, across = float(travel_px @ [x, y]), float(travel_px @ [-y, x])
    angle = float(np.degrees(np.arctan2(across * np.sign(along or 1.0), abs(along))))
    of_path = np.degrees(np.sqrt(float(variance_px2 @ np.array([y, x]) ** 2)) / length)
    return _quantity(angle, float(np.hypot(of_path, scale.axis_angle_sigma_deg)), scale.degrees_of_freedom)


def require_scale(scale: DisplacementSection | None) -> DisplacementSection:
    """Give the calibration, or say how to get one.

    Raises:
        InputError: there is none.
    """
    if scale is None:
        raise InputError(
            saw="a displacement of a bench without a calibration",
            expected="pixels a millimetre, measured on this bench",
            remedy="run kinopix calibrate displacement, and name its file in bench.toml: runs after that know their scale",
        )
    return scale
