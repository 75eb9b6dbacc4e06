"""How the image lies, which way the stage goes in it, and whether patterns come as planned.

What a real bench can know: the modulator's patterns are known, so is the shape of a target that somebody puts into the
light, upright as he sees it, and so is the direction in which the stage's position grows. An image of the target at rest by
the run's own patterns tells in which of eight ways the optics and the mirrors lay it; two places of the stage tell the axis.
"""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

import numpy as np

from instrument.calibration.orientation import Match, match_target, place_of
from instrument.calibration.pictures import PictureField
from instrument.config import AlignmentSection, Measured, upright_angle_deg
from instrument.measurement import Wiring, first_light, light_of, wiring_of
from instrument.patterns import letter
from instrument.plan import Plan
from instrument.reconstruction import inverse_hadamard
from instrument.recording import Recording
from instrument.schemes import image_rows_of, scheme_of
from instrument.session import Instrument
from protocols import Floats, InputError

CERTAIN: Final = 8.0
"""Log-likelihood by which an orientation is better than the next to be called certain: one error in 3,000."""

FOUND: Final = 30.0
"""Log-likelihood of a target over none from which on one is there."""

_CELLS: Final = 40
_BORDER: Final = 1 / 16
_FEW_PX: Final = 1.0


@dataclass(frozen=True, eq=False)
class AlignmentResult:
    """What was found."""

    section: AlignmentSection
    """For the calibration file."""

    image: Floats
    """``(m, m)`` image of the target at rest, as it lies."""

    match: Match
    """The target in it."""

    verdict: tuple[str, ...]
    """What is to be known and done, in sentences; the first says whether all is well."""

    @property
    def well(self) -> bool:
        """Whether the bench is wired as planned and its image upright and in the field."""
        return len(self.verdict) == 1


def target_letter() -> Floats:
    """Give the target that is taken where none is named: the letter F, as ``kinopix show letter`` shows it."""
    return letter(_CELLS).astype(np.float64)


def calibrate_alignment(
    bench: Instrument,
    field: PictureField,
    *,
    target: Floats | None = None,
    step_mm: float | None = None,
    frames: int | None = None,
    pattern_rate_hz: float = 20_000.0,
) -> AlignmentResult:
    """Image a target at rest, move the stage by a step, and image it again; then bring the stage back.

    Args:
        bench: open; the stage may be missing where there is no step.
        field: of the patterns, and where the runs are kept.
        target: transmission of the upright target, cut to its border; None for the letter F.
        step_mm: travel between both images; None leaves the stage where it is.
        frames: of each run; None for a quarter of the pixels, 4,096 at most.
        pattern_rate_hz: of the runs.

    Raises:
        InputError: there is no light, or no target in it.
        KinopixError: as ``Instrument.run``, or of the stage.
    """
    target = target_letter() if target is None else target
    plan = Plan.model_validate(
        {
            "frames": frames or min(field.image_size**2, max(256, field.image_size**2 // 4), 4096),
            "pattern_rate_hz": pattern_rate_hz,
            "image_size": field.image_size,
            "superpixel": field.superpixel,
        }
    )
    field.folder.mkdir(parents=True, exist_ok=True)
    recording = _recorded(bench, field, plan, "alignment-here")
    image, wiring = still_image(recording)
    band = min(1.0, plan.frames / field.image_size**2)
    match = match_target(image, target, band)
    if match.found < FOUND:
        raise InputError(
            saw=f"no target in the image (log-likelihood {match.found:.1f} over noise)",
            expected=f"the target, {FOUND:g} or more, bright on dark",
            remedy="put it upright into the light, in the middle of the field; more light, or more frames",
        )
    axis = None
    if step_mm is not None:
        there, _ = still_image(_after_step(bench, field, plan, step_mm))
        axis = _axis(image, there, match.template, step_mm, band)
    section = AlignmentSection(
        date=datetime.now(UTC),
        orientation=match.orientation,
        turn_deg=Measured(value=match.turn_deg, sigma=float(np.degrees(1 / match.height_px))),
        certainty=match.certainty,
        wiring=wiring,
        target_height_px=match.height_px,
        image_size=field.image_size,
        superpixel=field.superpixel,
        axis_angle_deg=None if axis is None else axis[0],
        px_per_mm=None if axis is None else axis[1],
        axis_angle_upright_deg=None if axis is None else upright_angle_deg(axis[0].value, match.orientation),
    )
    return AlignmentResult(section, image, match, verdict_of(section, match, step_mm))


def still_image(recording: Recording) -> tuple[Floats, Wiring]:
    """Give the image of an object at rest by the inverse Hadamard transform, and how the patterns are wired.

    Args:
        recording: by a scheme that shows Hadamard patterns, without motion.

    Returns:
        ``(m, m)`` image in counts, wiring taken back, and the wiring as it was.
    """
    scheme = scheme_of(recording.plan)
    rows = image_rows_of(scheme)
    light, variance = light_of(recording, scheme.light_weights)
    light = np.where(recording.frame_valid[:, None], light, np.nan)
    per_column = np.zeros(light.shape[1]) if recording.photon_counts else np.nanmedian(variance, axis=0)
    wiring, _, _ = wiring_of(light, per_column, scheme, recording.plan.image_size)
    measurement = first_light(recording)
    values, valid = measurement.values, measurement.valid
    pairs = rows.pairs[np.arange(len(values)) % len(rows.pairs)]
    difference = values[:, rows.positive] - values[:, rows.negative]
    return inverse_hadamard(difference[valid], pairs[valid], recording.plan.image_size), wiring


def verdict_of(section: AlignmentSection, match: Match, step_mm: float | None = None) -> tuple[str, ...]:
    """Say whether all is well, and what mends what is not."""
    found: list[str] = []
    if section.certainty < CERTAIN:
        found.append(
            f"the orientation is not certain (log-likelihood {section.certainty:.1f} over the next): more light, or more frames"
        )
    if section.orientation != "upright":
        found.append(
            f"the image is {section.orientation.replace('turned', 'turned by')}"
            f"{' degrees clockwise' if 'turned' in section.orientation else ' left to right'}: displacement is not touched by "
            "that, and pictures are turned upright by `upright` of instrument.calibration; to mend it on the bench, "
            + (
                "add or take out a mirror"
                if section.orientation.startswith("mirrored")
                else "turn the modulator or the object"
            )
        )
    if abs(section.turn_deg.value) > 2 * section.turn_deg.sigma:
        found.append(f"the target is turned by {section.turn_deg.value:.0f} degrees more: turn it, or the modulator")
    if section.wiring == "inverted":
        found.append(
            "the detector sees the mirrors that are off: put it on the other side of the modulator. Until then each run is "
            "taken back by its analysis, and light past the field is counted"
        )
    if section.wiring == "H- first":
        found.append(
            "H- is shown before H+: look at the order of the patterns, and at the sync edge (rising or falling). Until then "
            "each run is taken back by its analysis"
        )
    found += _in_field(match, section.image_size)
    moved_px = 0.0 if section.px_per_mm is None or step_mm is None else abs(section.px_per_mm.value * step_mm)
    if section.px_per_mm is not None and moved_px < max(_FEW_PX, 5 * section.px_per_mm.sigma * abs(step_mm or 0)):
        found.append(
            f"the target moved by {moved_px:.2f} px for {step_mm:g} mm: look whether the stage carries it, or move it farther "
            "(--step)"
        )
    well = "all is well: the image is upright, and patterns come as planned"
    return (well,) if not found else (f"{len(found)} things are to be looked at", *found)


def _in_field(match: Match, size: int) -> list[str]:
    """Name the borders of the field that the target comes near."""
    rim = size * _BORDER
    (column, row), (height, width) = match.corner_px, match.template.shape
    near = {"upper": row, "lower": size - row - height, "left": column, "right": size - column - width}
    cut = [name for name, room_px in near.items() if room_px < rim]
    if not cut:
        return []
    return [
        f"the target is near the {' and the '.join(cut)} border of the field: move it, or take a larger superpixel or image size"
    ]


def _recorded(bench: Instrument, field: PictureField, plan: Plan, name: str) -> Recording:
    out = field.folder / f"{name}.h5"
    return bench.run(plan, out, overwrite=field.overwrite, listeners=field.listeners)


def _after_step(bench: Instrument, field: PictureField, plan: Plan, step_mm: float) -> Recording:
    """Move the stage, record, and bring it back."""
    stage = bench.stage
    profile, start_mm = stage.limits.gentle_profile, stage.position().reported_mm
    stage.check(start_mm + step_mm, profile)
    stage.move_to(start_mm + step_mm, profile).wait()
    recording = _recorded(bench, field, plan, "alignment-after-a-step")
    stage.move_to(start_mm, profile).wait()
    return recording


def _axis(here: Floats, there: Floats, template: Floats, step_mm: float, band: float) -> tuple[Measured, Measured]:
    """Direction of the axis in degrees, and px a millimetre, from the images of two runs at rest."""
    places = [place_of(image, template, band) for image in (here, there)]
    moved = places[1][0] - places[0][0]
    sigma = np.hypot(places[0][1], places[1][1])
    distance = max(float(np.hypot(*moved)), 1e-12)
    along = moved / distance
    across = np.array([-along[1], along[0]])
    sign = 1.0 if step_mm > 0 else -1.0
    angle = float(np.degrees(np.arctan2(sign * moved[1], sign * moved[0])))
    angle_sigma = float(np.degrees(np.hypot(*(across * sigma)) / distance))
    return (
        Measured(value=angle, sigma=min(angle_sigma, 180.0)),
        Measured(value=distance / abs(step_mm), sigma=float(np.hypot(*(along * sigma))) / abs(step_mm)),
    )
