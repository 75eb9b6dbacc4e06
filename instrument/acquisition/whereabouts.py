"""Where the object will be during a plan, and whether it stays in the field: asked before anything moves.

A calibration knows how far the image moves for a millimetre, and where the object that it was made with was; a simulated bench
knows it of its own object. With the scale alone, only a travel that no object can make inside the field is certainly too long.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from instrument.config import Calibration, DisplacementSection
from instrument.plan import MotionPlan, Plan
from protocols import Floats, PixelGrid, PlacesObject, PlanError, Scene

_SMALLEST_PX: Final = 4.0  # an object that can be followed
_CERTAIN_PX: Final = 2.0  # beyond the border from which on the object has left it for certain
_STEPS: Final = 400  # moments of the run that are looked at


@dataclass(frozen=True, eq=False)
class Whereabouts:
    """Boxes of the object along the run."""

    time_s: Floats
    """``(n,)`` after the first pattern; the last is the end of the run."""

    shift_px: Floats
    """``(n, 2)``: displacement from the first pattern on."""

    box_px: Floats | None
    """``(n, 4)``: left, top, right and bottom edge of the object; None where its place is not known."""

    sigma_px: float
    """Standard uncertainty of the displacement at the end."""

    px_per_mm: Floats
    """``(2,)``: image scale along x and y."""

    @property
    def travel_px(self) -> float:
        """Length of the displacement."""
        return float(np.hypot(*self.shift_px[-1]))

    def beyond_px(self, size: int) -> Floats:
        """``(n,)``: how far the object reaches beyond the border of the field; below 0 while it is inside."""
        if self.box_px is None:
            spread = np.abs(self.shift_px) - (size - _SMALLEST_PX)
            return np.asarray(spread.max(axis=1), np.float64)
        low, high = -0.5 - self.box_px[:, :2], self.box_px[:, 2:] - (size - 0.5)
        return np.asarray(np.maximum(low, high).max(axis=1), np.float64)


def whereabouts(
    plan: Plan, grid: PixelGrid, calibration: Calibration | None, scene: Scene | None
) -> Whereabouts | None:
    """Tell where the object will be, by the calibration, or by a simulated bench that has none.

    Args:
        plan: the run.
        grid: its image grid.
        calibration: of the bench.
        scene: the simulated bench.

    Returns:
        The places; None where the plan moves nothing, or nobody knows.
    """
    motion = plan.motion
    if motion is None:
        return None
    time_s = np.linspace(0.0, plan.run_time_s, _STEPS)
    stage_mm = np.array(motion.positions_mm(plan.run_time_s, time_s.tolist()))
    known = None if calibration is None else calibration.displacement
    if known is not None:
        return _calibrated(known, time_s, stage_mm)
    offers: object = scene
    boxes = offers.object_boxes_px(grid, stage_mm) if isinstance(offers, PlacesObject) else None
    if boxes is None:
        return None
    shift_px = boxes[:, :2] - boxes[0, :2]
    gone_mm = float(stage_mm[-1] - stage_mm[0])
    scale = shift_px[-1] / gone_mm if gone_mm else np.zeros(2)
    return Whereabouts(time_s, shift_px, boxes, 0.0, scale)


def _calibrated(known: DisplacementSection, time_s: Floats, stage_mm: Floats) -> Whereabouts:
    scale = np.array([known.px_per_mm_x, known.px_per_mm_y])
    shift_px = (stage_mm - stage_mm[0])[:, None] * scale
    sigma_px = float(abs(stage_mm[-1] - stage_mm[0])) * known.px_per_mm_sigma
    if known.object_box_px is None or known.object_at_mm is None:
        return Whereabouts(time_s, shift_px, None, sigma_px, scale)
    moved = (stage_mm - known.object_at_mm)[:, None] * scale
    box = np.array(known.object_box_px) + np.concatenate([moved, moved], axis=1)
    return Whereabouts(time_s, shift_px, box, sigma_px, scale)


def where_in_words(found: Whereabouts, size: int) -> str:
    """Say how far the object moves, and from where to where."""
    x, y = found.shift_px[-1].tolist()
    travel = f"{found.travel_px:.1f} px of travel ({x:+.1f}, {y:+.1f})"
    if found.box_px is None:
        return f"{travel} in a field of {size} px; the place of the object is not known"
    ends = [((box[:2] + box[2:]) / 2).tolist() for box in (found.box_px[0], found.box_px[-1])]
    (x0, y0), (x1, y1) = ends
    return f"{travel}, from ({x0:.1f}, {y0:.1f}) to ({x1:.1f}, {y1:.1f}) px in a field of {size} px"


def leaving(found: Whereabouts, plan: Plan, travel_mm: tuple[float, float] | None) -> PlanError | None:
    """Say that the object certainly leaves the field, where it does, and by what to change the plan.

    Args:
        found: where it will be.
        plan: the run.
        travel_mm: of the stage, in which a better start must lie; None where there is none to ask.
    """
    size = plan.image_size
    certain_px = _CERTAIN_PX + 3 * found.sigma_px
    outside = found.beyond_px(size) > certain_px
    if not outside.any() or plan.motion is None:
        return None
    first = int(np.argmax(found.beyond_px(size) > 0))
    frame = int(found.time_s[max(first - 1, 0)] / plan.frame_time_s)
    when = "from the first frame on" if first == 0 else f"from frame {frame} of {plan.frames} on"
    return PlanError(
        saw=f"{where_in_words(found, size)}: the object is outside by up to {found.beyond_px(size).max():.0f} px, {when}",
        expected="an object that stays inside the field",
        remedy=_remedy(found, plan, plan.motion, frame, travel_mm),
    )


def _remedy(
    found: Whereabouts, plan: Plan, motion: MotionPlan, frame: int, travel_mm: tuple[float, float] | None
) -> str:
    ways: list[str] = []
    start_mm = _better_start_mm(found, plan, motion)
    if start_mm is not None and (travel_mm is None or travel_mm[0] <= start_mm <= travel_mm[1]):
        ways.append(f"set start_mm = {start_mm:.4g}")
    if frame > 0:
        ways.append(f"lower frames to {frame}")
    if frame > 0:
        share = frame * plan.frame_time_s / plan.run_time_s
        ways.append(f"lower velocity_mm_s to {abs(motion.velocity_mm_s) * share:.3g}")
    ways.append('set field = "may-leave" in [motion] to record it all the same')
    return ", or ".join(ways)


def _better_start_mm(found: Whereabouts, plan: Plan, motion: MotionPlan) -> float | None:
    """A start that keeps the object inside all the time, as nearly in the middle as the axis allows; None where there is none."""
    if found.box_px is None:
        return None
    low, high = found.box_px[:, :2].min(axis=0), found.box_px[:, 2:].max(axis=0)
    scale = found.px_per_mm
    power = float(scale @ scale)
    if not power:
        return None
    middle = (plan.image_size - 1) / 2
    move_mm = float(scale @ (middle - (low + high) / 2)) / power
    moved_low, moved_high = low + move_mm * scale, high + move_mm * scale
    inside = bool((moved_low > -0.5).all() and (moved_high < plan.image_size - 0.5).all())
    return motion.start_mm + move_mm if inside else None
