"""An object that leaves the field in the run, or comes into it: the light changes as its own image and path say that it must.

A lamp that fades looks the same to the total light alone. So the frames before the light falls are looked at first, as a run of
their own: they give an image and a path, and those say where the object goes. Where its pixels leave the field by as much as
light is missing, it is the object. Its path is then refined in all frames in which at least half of it is to be seen, by rows
that are zero outside the field, and nothing is divided by the total light.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from instrument.analysis.find import Found, find_path, placed_at
from instrument.choices import Background, Grid, Shape
from instrument.joint import refine
from instrument.measurement import Finding, Measurement, first_light
from instrument.reconstruction import reconstruct
from instrument.tracking import Trajectory
from protocols import Floats, InputError, Mask

_PARTS: Final = 20
"""Parts of a run over one of which the total light is averaged: more than a period of the mains."""

_SHORTER: Final = 4
"""How much shorter the times are over which a fall in the last part is looked for."""

_SHORTEST: Final = 8
"""Frames that they have at least."""

_SURE: Final = 6.0
"""Scatter of the means before by which the light must fall there."""

_FEWEST_FRAMES: Final = 200
"""Frames before the light falls below which nothing is concluded."""

_FALLEN: Final = 0.015
"""Share of the light that must be missing."""

_SIGMAS: Final = 4.0
"""Standard deviations of a mean by which it must be."""

_DRIFTS: Final = 0.05
"""Share by which the light may fall before an object leaves."""

_OUT: Final = 0.02
"""Share of the object that must leave."""

_SEEN: Final = 0.5
"""Share of the object that must be inside for a frame to be used."""

_AGREE: Final = 0.5
"""Share of the missing light that may be missing otherwise, or not be missing."""

_OBJECT: Final = 0.1
"""Share of the brightest pixel above which a pixel is the object's."""


@dataclass(frozen=True, eq=False)
class Leaving:
    """A run in which the object leaves."""

    whole: Measurement
    """The run with those frames valid in which it is wholly inside."""

    trajectory: Trajectory
    """Its path in these frames, and how it would go on."""

    share: Floats
    """``(frames,)``: share of the object that is inside the field."""

    end_frame: int
    """Frame after the last one in which it is wholly inside."""


def leaving(measurement: Measurement) -> Leaving | None:
    """Find out whether the object leaves the field before the run ends.

    Args:
        measurement: the run; its light model need not be known.
    """
    scheme = measurement.scheme
    if scheme.position is None or scheme.image_rows is None:
        return None
    fall = _fall(measurement.total, measurement.valid) or _late_fall(measurement.total, measurement.valid)
    if fall is None or fall.last < _FEWEST_FRAMES:
        return None
    last = fall.last
    before = np.arange(len(measurement)) < last
    whole = first_light(replace(measurement, valid=measurement.valid & before))
    found = find_path(whole, "smooth", None)
    if found.trajectory is None or found.trajectory.angle_deg is not None:
        return None
    path = going_on(found.trajectory, last)
    image = reconstruct(whole, path, "tv").at_patterns
    share = share_inside(image, path.displacement_px)
    expected = _means(share, measurement.valid, fall.half)[last:]
    off = float(np.abs(fall.light[last:] - expected).mean())
    if share[last:].min() > 1 - _OUT or off > _AGREE * float(1 - expected.mean()):
        return None
    return Leaving(whole, path, share, last)


def refuse_entering(measurement: Measurement) -> None:
    """Refuse a run in which the object comes into the field: displacement and image are those at frame 0, which did not see it.

    It is told from a lamp that gets brighter as an object that leaves is told from one that fades: by where its own image and
    path say that it was before.

    Args:
        measurement: the run; its light model need not be known.

    Raises:
        InputError: the object is not wholly inside the field until some frame.
    """
    scheme = measurement.scheme
    if scheme.position is None or scheme.position.period_px is None or scheme.image_rows is None:
        return
    trend, sigma = _trend(measurement.total, measurement.valid)
    frames = len(trend)
    steady = float(np.quantile(trend, 0.8))
    inside = np.flatnonzero(trend >= steady - max(_FALLEN * steady, _SIGMAS * sigma))
    part = frames // _PARTS
    if steady <= 0 or not len(inside) or inside[0] < part or frames - inside[0] - part // 2 < _FEWEST_FRAMES:
        return
    first = int(inside[0]) + part // 2
    whole = first_light(replace(measurement, valid=measurement.valid & (np.arange(frames) >= first)))
    path = find_path(whole, "smooth", None).trajectory
    if path is None:
        return
    place_px = path.displacement_px - path.displacement_px[first]
    backwards = going_on(replace(path, displacement_px=place_px[::-1]), frames - first)
    path = replace(path, displacement_px=backwards.displacement_px[::-1])
    share = share_inside(reconstruct(whole, path, "tv").at_patterns, path.displacement_px)
    missing = 1 - share[:first]
    off = float(np.abs(trend[:first] / steady - share[:first]).mean())
    if missing.max() >= _OUT and off <= _AGREE * float(missing.mean()):
        until = int(np.flatnonzero(share < 1 - _OUT)[-1]) + 1
        raise InputError(
            saw=f"an object that comes into the field until frame {until} of {frames}",
            expected="an object that is inside at frame 0, where displacement begins and whose image is shown",
            remedy="begin the run when it is inside: a later start_mm of [motion], or a longer run-up",
        )


def follow_out(left: Leaving, valid: Mask, background: Background, grid: Grid, *, shape: Shape = "rigid") -> Found:
    """Refine path and image, first where the object is wholly inside, then where at least half of it is.

    Args:
        left: what ``leaving`` gave.
        valid: ``(frames,)`` that were measured well.
        background: as in ``analyse``; one that stands still is found from the frames in which the object is wholly inside alone.
        grid: as in ``analyse``.
        shape: as in ``analyse``, where there is no background.
    """
    finer = None if grid == "auto" else int(grid)
    inside = refine(left.whole, left.trajectory, grid=finer, background=background)
    found = Found(inside.measurement, inside.trajectory, inside.image, inside.refinements)
    if inside.image.still is None:
        path = going_on(inside.trajectory, left.end_frame)
        share = share_inside(inside.image.at_patterns, path.displacement_px)
        seen = replace(inside.measurement, valid=valid & (share >= _SEEN))
        both = refine(seen, path, region=False, grid=finer, background="none", shape=shape)
        found = Found(both.measurement, both.trajectory, both.image, inside.refinements + both.refinements)
    if found.trajectory is None:
        return found
    placed = placed_at(
        found.measurement, known_where_seen(found.trajectory, found.measurement.valid), found.reconstruction
    )
    return _told(replace(found, trajectory=placed), left)


def known_where_seen(trajectory: Trajectory, seen: Mask) -> Trajectory:
    """Say that nothing is known of a path after the last frame in which the object was seen: it may do anything out there."""
    end = int(np.flatnonzero(seen)[-1]) + 1
    sigma_px = trajectory.sigma_px.copy()
    sigma_px[end:] = np.inf
    covariance = trajectory.covariance
    if covariance is not None:
        count = int(np.count_nonzero(covariance.frame < end))
        covariance = replace(
            covariance, frame=covariance.frame[:count], covariance_px2=covariance.covariance_px2[:, :count, :count]
        )
    return replace(trajectory, sigma_px=sigma_px, covariance=covariance)


def going_on(trajectory: Trajectory, end_frame: int) -> Trajectory:
    """Let a path that is known before a frame go on from there as it went: along a parabola through its last third."""
    place_px = trajectory.displacement_px.copy()
    frame = np.arange(len(place_px)) - (end_frame - 1)
    used = slice(end_frame - end_frame // 3, end_frame)
    fit = np.polynomial.polynomial.polyfit(frame[used], place_px[used], 2)
    onwards = np.polynomial.polynomial.polyval(frame[end_frame:].astype(np.float64), fit).T
    place_px[end_frame:] = onwards + place_px[end_frame - 1] - fit[0]
    return replace(trajectory, displacement_px=place_px)


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


def _told(found: Found, left: Leaving) -> Found:
    """Say of the measurement that the object leaves."""
    out = np.flatnonzero(left.share < 1 - _OUT)
    used = int(np.count_nonzero(found.measurement.valid & (left.share < 1 - _OUT)))
    text = f"the object leaves the field from frame {out[0]} on"
    how = f"{used} of these {len(out)} frames are used" if used else "no frame of these is used"
    sentence = f"{text}: {how}; to have all of it in all frames, keep it inside, or record fewer frames"
    finding = Finding("leaves the field", tuple(out.tolist()), text, sentence)
    return replace(found, measurement=replace(found.measurement, findings=(*found.measurement.findings, finding)))


@dataclass(frozen=True, eq=False)
class _Fall:
    """Light that falls towards the end of a run."""

    light: Floats
    """``(frames,)``: means around each frame, over the light before."""

    half: int
    """Frames before and after that each of these means reaches."""

    last: int
    """Frame until which it is steady."""


def _fall(total: Floats, valid: Mask) -> _Fall | None:
    """Find a fall that takes more than a part of the run."""
    trend, sigma = _trend(total, valid)
    steady = float(np.quantile(trend, 0.8))
    allowed = _SIGMAS * sigma
    half = len(trend) // _PARTS // 2
    last = int(np.flatnonzero(trend >= steady - max(_FALLEN * steady, allowed))[-1]) - half
    if steady <= 0 or last < 1 or last > len(trend) - 2 * half:
        return None
    if float(trend[:last].max()) > steady + max(_DRIFTS * steady, allowed):
        return None  # it fell from the beginning on, as that of a lamp
    return _Fall(trend / steady, half, last)


def _late_fall(total: Floats, valid: Mask) -> _Fall | None:
    """Find a fall in the last part of the run, by means over shorter times. Those of a lamp that flickers scatter before too."""
    half = max(len(total) // _PARTS // _SHORTER // 2, _SHORTEST // 2)
    trend = _means(total, valid, half)
    before = trend[: -len(total) // _PARTS]
    steady = float(np.median(before))
    scatter = 1.4826 * float(np.median(np.abs(before - steady)))
    last = int(np.flatnonzero(trend >= steady - max(_FALLEN * steady, _SURE * scatter))[-1]) - half
    if steady <= 0 or last > len(trend) - 2 * half:
        return None
    return _Fall(trend / steady, half, last)


def _trend(total: Floats, valid: Mask) -> tuple[Floats, float]:
    """Means of the total light over a part of the run around each frame; and their standard deviation by noise."""
    half = max(len(total) // _PARTS // 2, 1)
    known = total[valid]
    noise = float(np.median(np.abs(np.diff(known)))) / (0.6745 * 2**0.5) if len(known) > 1 else 0.0
    return _means(total, valid, half), noise / (2 * half + 1) ** 0.5


def _means(total: Floats, valid: Mask, half: int) -> Floats:
    """``(frames,)``: means of the total light of the valid frames up to ``half`` away from each frame."""
    frames = len(total)
    sums = np.concatenate(
        [np.zeros((2, 1)), np.cumsum([np.where(valid, total, 0.0), valid.astype(np.float64)], axis=1)], axis=1
    )
    low, high = np.maximum(np.arange(frames) - half, 0), np.minimum(np.arange(frames) + half + 1, frames)
    light, count = sums[:, high] - sums[:, low]
    return np.asarray(light / np.maximum(count, 1.0), np.float64)
