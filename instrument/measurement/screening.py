"""The screening of a recording before anything is made of it: what its counts say of themselves.

In this order: counts that no counter gives, counts that stand still, frames without light, values that slipped to other patterns,
single wild ones, and patterns that were wired otherwise than planned. What can be mended is mended, what cannot is NaN, and all
of it is told.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from instrument.measurement.dark_frames import dark_frames
from instrument.measurement.detector import noise_variance
from instrument.measurement.finding import Finding
from instrument.measurement.ripple import lamp_factor, ripples_seen
from instrument.measurement.slip_evidence import SlipEvidence
from instrument.measurement.slips import Change, Slips, in_step_again, moved_back, slips_of
from instrument.measurement.stuck_counts import saturated, stuck_counts
from instrument.measurement.suspects import suspects
from instrument.measurement.told import (
    HIGHEST_VALUE,
    tell_dark,
    tell_impossible,
    tell_saturated,
    tell_slips,
    tell_strange,
    tell_stuck,
    tell_wild,
    tell_wiring,
)
from instrument.measurement.wild_counts import wild_counts
from instrument.measurement.wiring import rewired, wiring_of
from instrument.recording import Recording
from instrument.schemes import Scheme, scheme_of
from protocols import Floats, Mask

_DIGITS: Final = 1e-6
"""Noise that is assumed at least, over the largest value."""

_DEEP: Final = 0.5
"""Brightness of a lamp over its mean below which its flicker is taken out before slips are looked for."""

_DARK_LAMP: Final = 0.2
"""Brightness of a lamp over its mean below which no slip is looked for."""

_DEAD: Final = 0.9
"""Share of the time dead at most that is corrected for here: beyond, a count is wild in any case."""


@dataclass(frozen=True, eq=False)
class Screened:
    """A recording whose values are what their patterns gave, or NaN."""

    recording: Recording
    """The recording, values mended; frames that are not usable are not valid."""

    findings: tuple[Finding, ...]
    """What was found."""

    slips: Slips
    """By how many patterns values came late or early."""

    inverted: Recording | None = None
    """The recording with the values of inverted pictures, whose noise those of the position patterns have; None where the
    pictures were not inverted."""


def screened(recording: Recording, slips: Slips | None = None) -> Screened:
    """Find what is wrong with the counts of a recording, and mend or mask it.

    Args:
        recording: as it was recorded.
        slips: by how many patterns values came late or early; None to find that by the counts.
    """
    recording = replace(recording, frame_valid=usable_frames(recording))
    scheme = scheme_of(recording.plan)
    values = np.where(recording.frame_valid[:, None], recording.values, np.nan)
    findings: list[Finding] = []
    impossible = _impossible(recording)
    values[impossible] = np.nan
    findings += tell_impossible(recording, impossible)

    stuck = stuck_counts(values, photon_counts=recording.photon_counts)
    values[stuck] = np.nan
    findings += [
        *tell_stuck(stuck),
        *tell_saturated(values, saturated(values, photon_counts=recording.photon_counts)),
    ]

    dark = dark_frames(values @ scheme.light_weights, photon_counts=recording.photon_counts)
    values[dark] = np.nan
    findings += tell_dark(dark)

    variance = _variance(values, recording.frame_valid, scheme, photon_counts=recording.photon_counts)
    light = _without_flicker(_light_of_counts(recording, values), recording, scheme)
    pair = _pair(scheme)
    wild = wild_counts(light, variance, pair)
    slips = slips_of(light, wild, variance, pair) if slips is None else slips
    likely, doubtful = light, slips.any and not slips.sure.any()
    if slips.any and not doubtful:  # what was wild in a place of another pattern may be none in its own
        findings += tell_slips(slips)
        likely = moved_back(light, slips)
        values, light = in_step_again(values, slips), in_step_again(light, slips)
        wild = wild_counts(light, variance, pair)
    elif not doubtful:
        findings += tell_strange(slips.sure)
        values[~slips.sure] = np.nan
    findings += tell_wild(wild)
    values[wild] = np.nan
    light[np.isnan(values)] = np.nan

    # The frame that is all on may be the first one, near which a shift from the start is not sure.
    seen = light.copy()
    seen[:1] = np.where(np.isfinite(light[:1]), light[:1], likely[:1])
    if doubtful:  # all values may be of other patterns: path and image will tell, and no frame is asked of the wiring
        seen[:] = np.nan
    wiring, frames, share = wiring_of(seen, variance, scheme, recording.plan.image_size)
    findings += tell_wiring(wiring, tuple(frames.tolist()), share)
    counted, values = values, rewired(values, wiring, scheme)
    if not findings:
        return Screened(recording, (), slips)
    valid = recording.frame_valid & np.isfinite(values).all(axis=1)
    background = None if recording.background is None else rewired(recording.background, wiring, scheme)
    kept, noisy = (np.where(recording.frame_valid[:, None], of, recording.values) for of in (values, counted))
    inverted = replace(recording, values=noisy, frame_valid=valid) if wiring == "inverted" else None
    mended = replace(recording, values=kept, frame_valid=valid, background=background)
    return Screened(mended, tuple(findings), slips, inverted)


def usable_frames(recording: Recording) -> Mask:
    """``(frames,)``: whether a frame is valid, or would be but for a slip that the run's own timing audit found in its counts."""
    usable = recording.frame_valid.copy()
    report = recording.timing
    if report is None or not report.slipped or report.verdict == "failed":
        return usable
    for first, end, _ in report.slipped:
        usable[first:end] = True
    patterns = np.array([*report.gaps, *report.doubles, *report.irregular], np.int64)
    usable[(patterns // recording.values.shape[1]).clip(max=len(usable) - 1)] = False
    return np.asarray(usable & (recording.frame_valid | np.isfinite(recording.values).all(axis=1)), bool)


def slips_of_counts(values: Floats, valid: Mask, scheme: Scheme, *, photon_counts: bool) -> Slips:
    """Find the shifts of a run by its counts as they came; see ``slips_of``.

    Args:
        values: ``(frames, patterns_per_frame)``.
        valid: ``(frames,)``: whether the frame may be used.
        scheme: what was shown.
        photon_counts: whether the values count photons.
    """
    return slips_of(*_asked(values, valid, scheme, photon_counts=photon_counts))


def suspects_of_counts(values: Floats, valid: Mask, scheme: Scheme, *, photon_counts: bool) -> tuple[Change, ...]:
    """Find the likeliest places of one change of the shift, whether or not there is any; see ``suspects``.

    Arguments as in ``slips_of_counts``.
    """
    evidence = SlipEvidence.of(*_asked(values, valid, scheme, photon_counts=photon_counts))
    return () if evidence is None else suspects(evidence)


def _asked(
    values: Floats, valid: Mask, scheme: Scheme, *, photon_counts: bool
) -> tuple[Floats, Mask, Floats, tuple[int, int] | None]:
    """Give the arguments of ``slips_of``: light, wild values, variance and the columns of a pair."""
    known = np.where(valid[:, None], values, np.nan)
    variance = _variance(values, valid, scheme, photon_counts=photon_counts)
    return known, wild_counts(known, variance, _pair(scheme)), variance, _pair(scheme)


def _pair(scheme: Scheme) -> tuple[int, int] | None:
    rows = scheme.image_rows
    return None if rows is None else (rows.positive, rows.negative)


def _variance(values: Floats, valid: Mask, scheme: Scheme, *, photon_counts: bool) -> Floats:
    """Variance of each column that does not depend on the light; all 0 for photon counts."""
    columns: int = values.shape[1]
    if photon_counts:
        return np.zeros(columns)
    found = noise_variance(values, scheme.light_weights, valid)
    known = np.abs(values[np.isfinite(values)])
    digits = (_DIGITS * float(known.max(initial=0.0))) ** 2  # of values that are computed, and have no noise
    return np.full(columns, max(found, digits, 1e-280) if np.isfinite(found) else 1e280)


def _light_of_counts(recording: Recording, values: Floats) -> Floats:
    """Counts without what dead time took: it bends the sum of a pair."""
    dead = values * (recording.dead_time_s / recording.picture_time_s) if recording.photon_counts else np.zeros(())
    return np.asarray(values / (1 - np.minimum(dead, _DEAD)), np.float64)


def _without_flicker(light: Floats, recording: Recording, scheme: Scheme) -> Floats:
    """Light as of a steady lamp where it flickers deeply: it then changes within a frame by as much as patterns do.

    What is measured while the lamp is nearly dark is NaN: it tells nothing.
    """
    weights = np.abs(scheme.light_weights)
    valid = np.asarray(np.isfinite(light).all(axis=1), bool)
    if not (weights.any() and valid.any()):
        return light
    moment_s = recording.pattern_time_s @ weights / weights.sum()
    total = np.where(valid, np.nan_to_num(light) @ scheme.light_weights, 0.0)
    lamp = lamp_factor(recording.pattern_time_s, ripples_seen(total, None, valid, moment_s))
    if lamp.min() > _DEEP:
        return light
    return np.where(lamp.min(axis=1, keepdims=True) < _DARK_LAMP, np.nan, light / lamp)


def _impossible(recording: Recording) -> Mask:
    """Values of valid frames that no detector gives."""
    values = recording.values
    wrong = ~(np.abs(values) <= HIGHEST_VALUE)
    if recording.photon_counts:
        wrong |= (values < 0) | (values != np.round(values))
    return np.asarray(wrong & recording.frame_valid[:, None], bool)
