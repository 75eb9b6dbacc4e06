"""The ``[displacement]`` section of a calibration file: how far the image moves for a millimetre of the stage."""

import math
from typing import Annotated, Final, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from instrument.config.calibration_section import GridSection
from protocols import Frozen

Pair: TypeAlias = tuple[float, float]
"""A number along x and one along y."""

Approach: TypeAlias = Literal["upward", "downward"]
"""From which side the stage came to a position: on its way to higher or to lower positions."""

_SMALLEST: Final = 1e-6
_LARGEST: Final = 1e6


class CalibrationPosition(Frozen):
    """One static image, or one group of frames of a moving run, and what it says."""

    stage_mm: float
    """Position that the stage told."""

    approach: Approach
    """From which side it came."""

    shift_px: Pair
    """Place of the object, relative to the first position, x and y."""

    sigma_px: Pair
    """Standard uncertainty of the shift, as the registration gives it."""

    residual_px: Pair
    """Shift minus what the fit gives for it."""


class DisplacementSection(GridSection):
    """Image scale and axis of the stage: image displacement = (``px_per_mm_x``, ``px_per_mm_y``) times stage travel in mm."""

    px_per_mm_x: Annotated[float, Field(ge=-_LARGEST, le=_LARGEST)]
    """Image pixels to the right (x) for a millimetre of the stage; negative where the image goes to the left."""

    px_per_mm_y: Annotated[float, Field(ge=-_LARGEST, le=_LARGEST)]
    """Image pixels down (y) for a millimetre of the stage."""

    covariance: tuple[Pair, Pair] = ((0.0, 0.0), (0.0, 0.0))
    """Covariance of ``px_per_mm_x`` and ``px_per_mm_y``, (px/mm)^2. Zeros where the numbers were typed in without one."""

    degrees_of_freedom: Annotated[int, Field(ge=1)] | None = None
    """Degrees of freedom behind the covariance, for Student's t; None where the normal distribution serves."""

    method: Literal["static images", "moving run", "stated"] = "stated"
    """How it was measured: with images of the object at rest, along a run, or not at all by this program."""

    rms_residual_px: Annotated[float, Field(ge=0)] | None = None
    """Root mean square of the residuals, both axes."""

    backlash_mm: float | None = None
    """Position told on the way up minus position told on the way down for the same place of the object; None where
    the stage came from one side only."""

    backlash_sigma_mm: Annotated[float, Field(ge=0)] | None = None
    """Standard uncertainty of that."""

    object_at_mm: float | None = None
    """Stage position at which ``object_box_px`` holds."""

    object_box_px: tuple[float, float, float, float] | None = None
    """Left, top, right and bottom edge of the object that was used, at ``object_at_mm``; the field reaches from -0.5 to
    image_size - 0.5. With it, the place of the object during a plan is known before anything moves."""

    positions: tuple[CalibrationPosition, ...] = ()
    """What was fitted."""

    @model_validator(mode="after")
    def _a_scale(self) -> Self:
        if not _SMALLEST <= self.px_per_mm <= _LARGEST:
            msg = f"px_per_mm_x and px_per_mm_y make {self.px_per_mm:g} px/mm: from {_SMALLEST:g} to {_LARGEST:g}"
            raise ValueError(msg)
        (xx, xy), (yx, yy) = self.covariance
        if not math.isclose(xy, yx, rel_tol=1e-9, abs_tol=1e-300) or min(xx, yy) < 0 or xx * yy < xy * yx * (1 - 1e-9):
            raise ValueError("covariance is no covariance: it is not symmetric, or gives a variance below 0")
        if (self.object_at_mm is None) != (self.object_box_px is None):
            raise ValueError("object_at_mm and object_box_px belong together: give both, or none")
        if self.object_box_px is not None:
            left, top, right, bottom = self.object_box_px
            if not (left < right and top < bottom):
                raise ValueError("object_box_px is left, top, right, bottom: right above left, and bottom above top")
        return self

    @property
    def px_per_mm(self) -> float:
        """Image pixels for a millimetre of the stage, along its axis."""
        return math.hypot(self.px_per_mm_x, self.px_per_mm_y)

    @property
    def axis(self) -> Pair:
        """Direction of positive travel in the image: a unit vector, x to the right and y down."""
        return self.px_per_mm_x / self.px_per_mm, self.px_per_mm_y / self.px_per_mm

    @property
    def axis_angle_deg(self) -> float:
        """Direction of positive travel in the image: 0 along x (right), 90 along y (down)."""
        return math.degrees(math.atan2(self.px_per_mm_y, self.px_per_mm_x))

    @property
    def px_per_mm_sigma(self) -> float:
        """Standard uncertainty of ``px_per_mm``, to first order."""
        x, y = self.axis
        return math.sqrt(self._variance(x, y))

    @property
    def axis_angle_sigma_deg(self) -> float:
        """Standard uncertainty of ``axis_angle_deg``, to first order."""
        x, y = self.axis
        return math.degrees(math.sqrt(self._variance(-y, x)) / self.px_per_mm)

    def _variance(self, along_x: float, along_y: float) -> float:
        (xx, xy), (_, yy) = self.covariance
        return max(0.0, xx * along_x**2 + 2 * xy * along_x * along_y + yy * along_y**2)
