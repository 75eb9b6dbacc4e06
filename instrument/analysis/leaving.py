"""An object that leaves the field in the run, or comes into it: the light changes as its own image and path say that it must.

A lamp that fades looks the same to the total light alone. So the frames in which the light is steady are looked at first, as a
run of their own: they give an image and a path, and those say where the object goes, and where it came from. Where its pixels
are outside the field by as much as light is missing, it is the object. Its path is then refined in all frames in which at least
half of it is to be seen, by rows that are zero outside the field, and nothing is divided by the total light.

Displacement and image of an object that comes into the field are those of the first frame in which all of it is inside.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from instrument.analysis.causes import FEWEST_FRAMES
from instrument.analysis.changing_light import Change, fall_of, means, rise_of
from instrument.analysis.find import Found, placed_at, reference_frame_of
from instrument.choices import Background, Grid, Shape
from instrument.joint import refine
from instrument.measurement import Finding, FindingKind, LightModel, Measurement, first_light
from instrument.reconstruction import reconstruct
from instrument.tracking import Trajectory, track
from protocols import Floats, InputError, Mask

_OUT: Final = 0.02
"""Share of the object that must be outside."""

_SEEN: Final = 0.5
"""Share of the object that must be inside for a frame to be used."""

_AGREE: Final = 0.2
"""Mean difference of the light from what the object's image and path predict, over the light that they predict to be missing, up
to which the object is believed to cross the border: objects that did differed by 0.003 to 0.16, and the lamp whose drift looked
most like one by 0.25."""

_AGREE_SHORT: Final = 0.5
"""The same where the light changes in a tenth of the run or less: in so short a time a lamp hardly drifts, though it flickers."""

_SHORT: Final = 10
"""Frames of a run over those in which the light changes, from which on the change is short."""

_MORE_PX: Final = 3
"""Pixels that are added at each side to the region of the object's image where the object crosses the border of the field."""

_FITTED: Final = (3, 1)
"""The parabola that the path is extrapolated by goes through a third of what is known of it, or through all: that which explains
the light better is taken. A third follows a path that bends otherwise before, all of it is surer in little light."""

_OBJECT: Final = 0.1
"""Share of the brightest pixel above which a pixel is the object's."""


@dataclass(frozen=True, eq=False)
class Crossing:
    """A run in which the object crosses the border of the field."""

    whole: Measurement
    """The run with those frames valid in which it is wholly inside."""

    trajectory: Trajectory
    """Its path in these frames, and how it would go on before and after, relative to the first of them if it comes in."""

    share: Floats
    """``(frames,)``: share of the object that is inside the field."""

    first_frame: int
    """First frame in which it is wholly inside, by the light, or first that was measured."""

    fitted: int
    """Which part of the path it is extrapolated by, as in ``going_on``."""

    end_frame: int
    """Frame after the last one in which it is wholly inside, by the light."""


def crossing(measurement: Measurement) -> Crossing | None:
    """Find out whether the object leaves the field before the run ends, or comes into it after the run began.

    Args:
        measurement: the run; its light model need not be known.
    """
    scheme = measurement.scheme
    if scheme.position is None or scheme.image_rows is None:
        return None
    rise, fall = _changes(measurement)
    if rise is not None and fall is not None:  # the lamp may make one of them
        return _seen(measurement, rise, fall) or _seen(measurement, None, fall) or _seen(measurement, rise, None)
    return _seen(measurement, rise, fall)


def _changes(measurement: Measurement) -> tuple[Change | None, Change | None]:
    """Give where the light rises at the beginning of a run, and where it falls at its end."""
    position = measurement.scheme.position
    dark = _without_light(measurement)
    total, known = np.where(dark, 0.0, measurement.total), measurement.valid | dark
    rise = None if position is None or position.period_px is None else rise_of(total, known)
    return rise, fall_of(total, known)


def _by_leak(measurement: Measurement, light: LightModel, rise: Change | None, fall: Change | None) -> bool:
    """Whether changes are gone where a leak that was found is taken off: it lets the light change as the fringes do."""
    if not light.leak.value:
        return False
    rises, falls = _changes(measurement.lit_by(measurement.light.model_copy(update={"leak": light.leak})))
    return (rise is not None and rises is None) or (fall is not None and falls is None)


def _seen(measurement: Measurement, rise: Change | None, fall: Change | None) -> Crossing | None:
    """Follow the object where the light is steady; None where it is not outside by as much as light is missing elsewhere."""
    frames = len(measurement)
    first = reference_frame_of(measurement) if rise is None else rise.frames.stop
    end = frames if fall is None else fall.frames.start
    if (rise is None and fall is None) or end - first < FEWEST_FRAMES:
        return None
    inside = (np.arange(frames) >= first) & (np.arange(frames) < end)
    try:
        whole = first_light(replace(measurement, valid=measurement.valid & inside))
        found = track(whole, reference_frame=first)
        if found.angle_deg is not None or _by_leak(measurement, whole.light, rise, fall):
            return None
        image = reconstruct(whole, found, "tv").at_patterns
    except (InputError, np.linalg.LinAlgError):  # no object can be followed where the light is steady
        return None
    changes = [change for change in (rise, fall) if change is not None]
    tried: list[tuple[float, Crossing]] = []
    for fitted in _FITTED:
        path = going_on(found, first, end, fitted)
        share = share_inside(image, path.displacement_px)
        off = max(_disagreement(change, share, measurement) for change in changes)
        tried.append((off, Crossing(whole, path, share, first, fitted, end)))
    off, crossed = min(tried, key=lambda one: one[0])
    return crossed if off <= 1 else None


def _disagreement(change: Change, share: Floats, measurement: Measurement) -> float:
    """Give by how much the light differs from the share that is inside, over what is allowed; infinite where all of it stays."""
    if share[change.frames].min() > 1 - _OUT:
        return np.inf
    dark = _without_light(measurement)
    lit = np.where(dark & (share < _SEEN), 0.0, share)  # extrapolated so far, the path is in error itself
    expected = means(lit, measurement.valid | dark, change.half)[change.frames]
    off, missing = float(np.abs(change.light[change.frames] - expected).mean()), float(1 - expected.mean())
    agree = _AGREE_SHORT if _SHORT * len(expected) <= len(measurement) else _AGREE
    return off / (agree * missing) if missing > 0 else np.inf


def _without_light(measurement: Measurement) -> Mask:
    """``(frames,)``: frames that were masked because there was no light in them."""
    dark = np.zeros(len(measurement), np.bool_)
    for finding in measurement.findings:
        if finding.kind == "no light":
            dark[list(finding.frames)] = True
    return dark


def follow(found: Crossing, valid: Mask, background: Background, grid: Grid, *, shape: Shape = "rigid") -> Found:
    """Refine path and image, first where the object is wholly inside, then where at least half of it is.

    Args:
        found: what ``crossing`` gave.
        valid: ``(frames,)`` that were measured well.
        background: as in ``analyse``; one that stands still is found from the frames in which the object is wholly inside alone.
            Where the object comes in, ``auto`` looks for none: the coarse patterns of the first frames, which tell it from the
            object, were not seen.
        grid: as in ``analyse``.
        shape: as in ``analyse``, where there is no background.
    """
    finer = None if grid == "auto" else int(grid)
    comes = found.trajectory.reference_frame > 0
    behind = "none" if comes and background == "auto" else background
    inside = refine(found.whole, found.trajectory, grid=finer, background=behind)
    refined = Found(inside.measurement, inside.trajectory, inside.image, inside.refinements)
    if inside.image.still is None:
        path = going_on(inside.trajectory, found.first_frame, found.end_frame, found.fitted)
        share = share_inside(inside.image.at_patterns, path.displacement_px)
        seen = replace(inside.measurement, valid=valid & (share >= _SEEN))
        region = inside.image.region.grown(_MORE_PX, len(inside.image.at_patterns))
        both = refine(seen, path, region=region, grid=finer, background="none", shape=shape)
        refined = Found(both.measurement, both.trajectory, both.image, inside.refinements + both.refinements)
    if refined.trajectory is None:
        return refined
    path = refined.trajectory.known_where(refined.measurement.valid)
    if not comes:
        path = placed_at(refined.measurement, path, refined.reconstruction)
    return _told(replace(refined, trajectory=path), found)


def going_on(trajectory: Trajectory, first_frame: int, end_frame: int, fitted: int = 3) -> Trajectory:
    """Extrapolate a path that is known from one frame to before another, both ways, along parabolas through its outer parts.

    Args:
        trajectory: the path.
        first_frame: first frame in which it is known.
        end_frame: frame after the last one.
        fitted: known frames over those that each parabola goes through.
    """
    place_px = trajectory.displacement_px.copy()
    place_px[first_frame:] = _onwards(place_px[first_frame:], end_frame - first_frame, fitted)
    place_px[:end_frame] = _onwards(place_px[:end_frame][::-1], end_frame - first_frame, fitted)[::-1]
    return replace(trajectory, displacement_px=place_px)


def _onwards(place_px: Floats, end_frame: int, fitted: int) -> Floats:
    """Extrapolate places, ``(frames, 2)``, that are known before a frame."""
    frame = np.arange(len(place_px)) - (end_frame - 1)
    used = slice(end_frame - end_frame // fitted, end_frame)
    fit = np.polynomial.polynomial.polyfit(frame[used], place_px[used], 2)
    onwards = np.polynomial.polynomial.polyval(frame[end_frame:].astype(np.float64), fit).T
    return np.concatenate([place_px[:end_frame], onwards + place_px[end_frame - 1] - fit[0]])


def share_inside(image: Floats, displacement_px: Floats) -> Floats:
    """``(frames,)``: share of an object's light that is inside the field when it is displaced.

    Args:
        image: ``(m, m)`` at displacement 0.
        displacement_px: ``(frames, 2)``, x and y.
    """
    row, column = np.nonzero(image > _OBJECT * image.max())
    light = image[row, column]
    size = len(image)
    inside = np.ones((len(displacement_px), len(light)), bool)
    for axis, at in enumerate((column, row)):
        place = at + displacement_px[:, axis : axis + 1]
        inside &= (place > -0.5) & (place < size - 0.5)
    return np.asarray(inside @ light / light.sum(), np.float64)


def _told(found: Found, crossed: Crossing) -> Found:
    """Add to the findings that the object comes into the field, leaves it, or both."""
    out = np.flatnonzero(crossed.share < 1 - _OUT)
    findings = list(found.measurement.findings)
    kinds: tuple[FindingKind, FindingKind] = "comes into the field", "leaves the field"
    for kind, frames in zip(kinds, (out[out < crossed.first_frame], out[out >= crossed.end_frame]), strict=True):
        if len(frames):
            comes = kind == "comes into the field"
            when = f"until frame {frames[-1] + 1}" if comes else f"from frame {frames[0]} on"
            against = f"; displacement and image are those of frame {crossed.first_frame}" if comes else ""
            used = int(np.count_nonzero(found.measurement.valid[frames]))
            how = f"{used} of these {len(frames)} frames are used" if used else "no frame of these is used"
            text = f"the object {kind} {when}"
            sentence = (
                f"{text}: {how}{against}; to have all of it in all frames, keep it inside, or record fewer frames"
            )
            findings.append(Finding(kind, tuple(frames.tolist()), text + against, sentence))
    return replace(found, measurement=replace(found.measurement, findings=tuple(findings)))
