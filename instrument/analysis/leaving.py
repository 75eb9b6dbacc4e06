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
from instrument.analysis.find import Found, placed_at
from instrument.choices import Background, Grid, Shape
from instrument.joint import refine
from instrument.measurement import Finding, FindingKind, Measurement, first_light
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
    """First frame in which it is wholly inside, by the light."""

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
    fall = fall_of(measurement.total, measurement.valid)
    rise = None if scheme.position.period_px is None else rise_of(measurement.total, measurement.valid)
    if rise is not None and fall is not None:  # the lamp may make one of them
        return _seen(measurement, rise, fall) or _seen(measurement, None, fall) or _seen(measurement, rise, None)
    return _seen(measurement, rise, fall)


def _seen(measurement: Measurement, rise: Change | None, fall: Change | None) -> Crossing | None:
    """Follow the object where the light is steady; None where it is not outside by as much as light is missing elsewhere."""
    frames = len(measurement)
    first, end = 0 if rise is None else rise.frames.stop, frames if fall is None else fall.frames.start
    if (rise is None and fall is None) or end - first < FEWEST_FRAMES:
        return None
    inside = (np.arange(frames) >= first) & (np.arange(frames) < end)
    try:
        whole = first_light(replace(measurement, valid=measurement.valid & inside))
        found = track(whole, reference_frame=first)
        if found.angle_deg is not None:
            return None
        path = going_on(found, first, end)
        image = reconstruct(whole, path, "tv").at_patterns
    except (InputError, np.linalg.LinAlgError):  # no object can be followed where the light is steady
        return None
    share = share_inside(image, path.displacement_px)
    for change in (rise, fall):
        if change is not None:
            expected = means(share, measurement.valid, change.half)[change.frames]
            off = float(np.abs(change.light[change.frames] - expected).mean())
            agree = _AGREE_SHORT if _SHORT * len(expected) <= frames else _AGREE
            if share[change.frames].min() > 1 - _OUT or off > agree * float(1 - expected.mean()):
                return None
    return Crossing(whole, path, share, first, end)


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
        path = going_on(inside.trajectory, found.first_frame, found.end_frame)
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


def going_on(trajectory: Trajectory, first_frame: int, end_frame: int) -> Trajectory:
    """Let a path that is known from a frame to another go on as it went, both ways: along parabolas through its outer thirds."""
    place_px = trajectory.displacement_px.copy()
    place_px[first_frame:] = _onwards(place_px[first_frame:], end_frame - first_frame)
    place_px[:end_frame] = _onwards(place_px[:end_frame][::-1], end_frame - first_frame)[::-1]
    return replace(trajectory, displacement_px=place_px)


def _onwards(place_px: Floats, end_frame: int) -> Floats:
    """Let places, ``(frames, 2)``, that are known before a frame go on from there along a parabola through their last third."""
    frame = np.arange(len(place_px)) - (end_frame - 1)
    used = slice(end_frame - end_frame // 3, end_frame)
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
            against = f", displacement and image are those of frame {crossed.first_frame}" if comes else ""
            used = int(np.count_nonzero(found.measurement.valid[frames]))
            how = f"{used} of these {len(frames)} frames are used" if used else "no frame of these is used"
            text = f"the object {kind} {when}"
            sentence = (
                f"{text}: {how}{against}; to have all of it in all frames, keep it inside, or record fewer frames"
            )
            findings.append(Finding(kind, tuple(frames.tolist()), text + against, sentence))
    return replace(found, measurement=replace(found.measurement, findings=tuple(findings)))
