"""Calibration of real displacement the paper's way: static images at positions of the stage, and a line through their places.

References:
    Li, Cai, Wang, Yao, Zhao, "Single-pixel imaging of a translational object", Opt. Express (2023): real displacement from static
    images at three positions of the stage.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import numpy as np

from instrument.calibration.line_fit import LineFit, fit_line
from instrument.calibration.registration import Registration, registered
from instrument.config import Approach, CalibrationPosition, DisplacementSection
from instrument.measurement import first_light
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.session import Instrument
from protocols import Floats, InputError, MotionProfile, StagePosition

FEWEST_POSITIONS: Final = 3
"""Positions of a calibration: with two, nothing tells a bend or a slip from a scale."""

_CLOSEST_MM: Final = 0.01  # from one position to the next: a few steps of a motor
_REACHED_MM: Final = 0.05  # from a target at which the stage has reached it
_STILL: Final = 4.0  # standard deviations below which the image did not move
_KNOWN: Final = 0.01  # relative uncertainty of the scale that is no calibration any more
_OUTLIER: Final = 6.0  # standard deviations of the residual of one place
_LEAST_OUTLIER_PX: Final = 0.3


@dataclass(frozen=True)
class Ladder:
    """Where static images are taken, and how the stage goes there."""

    positions_mm: tuple[float, ...]
    """Positions, in any order; they are taken ascending, and then descending."""

    both_sides: bool = True
    """Whether every position is visited on the way up and on the way down, for the backlash."""

    run_out_mm: float = 0.5
    """How far beyond a position the stage goes to come to it from the wanted side."""

    velocity_mm_s: float = 10.0
    """Speed between positions; lowered to what the stage allows."""

    settle_s: float = 0.2
    """Rest before an image is taken."""

    def __post_init__(self) -> None:
        """Refuse positions that make no line.

        Raises:
            InputError: fewer than three, or two that are the same.
        """
        ordered = sorted(self.positions_mm)
        closest = min(np.diff(ordered), default=0.0)
        if len(ordered) < FEWEST_POSITIONS or not np.isfinite(ordered).all() or closest < _CLOSEST_MM:
            raise InputError(
                saw=f"the positions {', '.join(f'{at:g}' for at in self.positions_mm)} mm"
                + (f", two of them {closest:g} mm apart" if len(ordered) > 1 else ""),
                expected=f"{FEWEST_POSITIONS} or more, at least {_CLOSEST_MM:g} mm from each other",
                remedy="spread the positions over the whole part of the field that the object may cross",
            )

    @property
    def visits(self) -> tuple[tuple[float, Approach], ...]:
        """Position and approach of each image, in order."""
        up = sorted(self.positions_mm)
        upward: list[tuple[float, Approach]] = [(at, "upward") for at in up]
        downward: list[tuple[float, Approach]] = [(at, "downward") for at in reversed(up)]
        return tuple(upward + downward) if self.both_sides else tuple(upward)

    def profile(self, bench: Instrument) -> MotionProfile:
        """Give how the stage moves between positions."""
        limits = bench.stage.limits
        return MotionProfile(
            velocity_mm_s=min(self.velocity_mm_s, limits.max_velocity_mm_s),
            acceleration_mm_s2=min(50.0, limits.max_acceleration_mm_s2),
        )


@dataclass(frozen=True, eq=False)
class Visit:
    """A static image of the object at one position of the stage."""

    recording: Recording
    """The run, without motion."""

    stage_mm: float
    """Position that the stage told, at rest."""

    approach: Approach
    """From which side it came."""

    @property
    def name(self) -> str:
        """What messages call it."""
        return f"{self.stage_mm:g} mm ({self.approach})"


def static_plan(
    image_size: int = 128, superpixel: int = 2, pattern_rate_hz: float = 1000.0, frames: int | None = None
) -> Plan:
    """Give the plan of a static image: conventional differential Hadamard imaging, no motion.

    Args:
        image_size: pixels a side.
        superpixel: mirrors a side of a pixel.
        pattern_rate_hz: slow, so that the mirrors' transition is nothing and the light of a pattern much.
        frames: Hadamard patterns with their complements; None takes 61.01 % of all, as the paper's reference image: 9,996 of
            16,384 at 128 px, 19,992 patterns.
    """
    return Plan.model_validate(
        {
            "scheme": "hadamard",
            "frames": round(image_size**2 * 0.6101) if frames is None else frames,
            "pattern_rate_hz": pattern_rate_hz,
            "image_size": image_size,
            "superpixel": superpixel,
        }
    )


def take_views(
    bench: Instrument,
    ladder: Ladder,
    plan: Plan,
    folder: Path,
    on_visit: Callable[[int, int, str], None] | None = None,
    *,
    overwrite: bool = False,
) -> list[Visit]:
    """Bring the stage to each position, and take a static image there. The recordings stay in ``folder``.

    Args:
        bench: open.
        ladder: where to.
        plan: of each image; without motion, of a scheme with an image.
        folder: for the recordings ``view-01.h5`` and so on; made if it is not there.
        on_visit: told the number of images taken, of all, and what comes next.
        overwrite: replace recordings that are there.

    Raises:
        InputError: the plan moves the stage or has no image, or a recording is there already.
        PlanError: a position that the stage cannot reach, or a plan that the bench cannot carry out. Nothing has moved.
        DeviceError: the stage is not where it was sent.
    """
    if plan.motion is not None:
        raise InputError(
            saw="a plan with [motion] for static images",
            expected="an object at rest",
            remedy="leave out the [motion] table",
        )
    stage, profile = bench.stage, ladder.profile(bench)
    ends = min(ladder.positions_mm) - ladder.run_out_mm, max(ladder.positions_mm) + ladder.run_out_mm
    for target_mm in ends if ladder.both_sides else (ends[0], max(ladder.positions_mm)):
        stage.check(target_mm, profile)
    bench.check(plan).raise_errors()
    folder.mkdir(parents=True, exist_ok=True)
    visits: list[Visit] = []
    for number, (at_mm, approach) in enumerate(ladder.visits):
        if on_visit is not None:
            on_visit(number, len(ladder.visits), f"{at_mm:g} mm, {approach}")
        beyond_mm = at_mm - ladder.run_out_mm if approach == "upward" else at_mm + ladder.run_out_mm
        before_mm = stage.position().reported_mm
        if (before_mm > beyond_mm) if approach == "upward" else (before_mm < beyond_mm):
            stage.move_to(beyond_mm, profile).wait()
        place = stage.move_to(at_mm, profile).wait()
        bench.devices.clock.sleep_s(ladder.settle_s)
        place = stage.position()
        _refuse_elsewhere(place, at_mm)
        recording = bench.run(plan, folder / f"view-{number + 1:02d}.h5", overwrite=overwrite)
        visits.append(Visit(recording, place.reported_mm, approach))
    return visits


def _refuse_elsewhere(place: StagePosition, target_mm: float) -> None:
    if abs(place.reported_mm - target_mm) > _REACHED_MM:
        raise InputError(
            device="stage",
            saw=f"{place.reported_mm:g} mm",
            expected=f"{target_mm:g} mm",
            remedy="look for a limit switch, or an obstacle",
        )


def displacement_of(visits: Sequence[Visit], date: datetime | None = None) -> DisplacementSection:
    """Register static images and fit scale and axis.

    Args:
        visits: at three positions or more.
        date: of the calibration; None for now.

    Raises:
        InputError: no object, at one position or at all; an object at the border of the field; a second one that moves otherwise;
            an image that did not move, or too little for a calibration; one position that does not fit to the others.
    """
    found = registered(
        [first_light(visit.recording).image_values(steady_object=True) for visit in visits],
        [visit.name for visit in visits],
    )
    position_mm = np.array([visit.stage_mm for visit in visits])
    upward = np.array([1.0 if visit.approach == "upward" else -1.0 for visit in visits])
    fit = fit_line(position_mm, upward, found.place_px, found.covariance_px2)
    _refuse_no_motion(fit, found, position_mm)
    _refuse_slip(fit, found, visits)
    plan = visits[0].recording.plan
    section = _section(fit, found, visits, plan, date or datetime.now(UTC))
    _refuse_too_close(section, position_mm)
    return section


def _section(
    fit: LineFit, found: Registration, visits: Sequence[Visit], plan: Plan, date: datetime
) -> DisplacementSection:
    (xx, xy), (_, yy) = fit.covariance.tolist()
    positions = tuple(
        CalibrationPosition(
            stage_mm=visit.stage_mm,
            approach=visit.approach,
            shift_px=_pair(place),
            sigma_px=_pair(np.sqrt(np.diag(covariance))),
            residual_px=_pair(residual),
        )
        for visit, place, covariance, residual in zip(
            visits, found.place_px, found.covariance_px2, fit.residual_px, strict=True
        )
    )
    return DisplacementSection(
        date=date,
        image_size=plan.image_size,
        superpixel=plan.superpixel,
        px_per_mm_x=float(fit.px_per_mm[0]),
        px_per_mm_y=float(fit.px_per_mm[1]),
        covariance=((xx, xy), (xy, yy)),
        degrees_of_freedom=fit.degrees_of_freedom,
        method="static images",
        rms_residual_px=float(np.sqrt(np.mean(fit.residual_px**2))),
        backlash_mm=fit.backlash_mm,
        backlash_sigma_mm=fit.backlash_sigma_mm,
        object_at_mm=visits[0].stage_mm,
        object_box_px=found.box_px,
        positions=positions,
    )


def _pair(numbers: Floats) -> tuple[float, float]:
    x, y = numbers.tolist()
    return float(x), float(y)


def _refuse_no_motion(fit: LineFit, found: Registration, position_mm: Floats) -> None:
    """Refuse images in which nothing moved."""
    span_mm = float(np.ptp(position_mm))
    step_px = fit.px_per_mm * span_mm
    sigma_px = float(np.sqrt(np.max(np.diagonal(found.covariance_px2, axis1=1, axis2=2))))
    if float(np.hypot(*step_px)) < _STILL * sigma_px:
        raise InputError(
            saw=f"an image that moved by {np.hypot(*step_px):.3f} +- {sigma_px:.3f} px while the stage told {span_mm:g} mm",
            expected="an image that moves with the stage",
            remedy="look whether the stage moves, whether the object stands on it, and whether the positions are far enough "
            "apart",
        )


def _refuse_slip(fit: LineFit, found: Registration, visits: Sequence[Visit]) -> None:
    """Refuse one position that does not fit to the others."""
    deviation = np.sqrt(
        np.einsum("na,nab,nb->n", fit.residual_px, np.linalg.inv(found.covariance_px2), fit.residual_px)
    )
    length_px = np.hypot(*fit.residual_px.T)
    worst = int(np.argmax(deviation))
    if deviation[worst] > _OUTLIER and length_px[worst] > _LEAST_OUTLIER_PX:
        raise InputError(
            saw=f"the object {length_px[worst]:.2f} px from where the other positions put it, at {visits[worst].name}",
            expected="places on one straight line, in proportion to the stage's positions",
            remedy="look for missed steps, a loose object or a second object; then calibrate again",
        )


def _refuse_too_close(section: DisplacementSection, position_mm: Floats) -> None:
    """Refuse a scale that is hardly known."""
    relative = section.px_per_mm_sigma / section.px_per_mm
    if relative > _KNOWN:
        raise InputError(
            saw=f"positions too close together: over {np.ptp(position_mm):g} mm the image moved by "
            f"{np.ptp(position_mm) * section.px_per_mm:.2f} px, which gives the scale to {100 * relative:.1f} % only",
            expected=f"{100 * _KNOWN:g} % or better",
            remedy="spread the positions over the whole part of the field that the object may cross, or take more light",
        )
