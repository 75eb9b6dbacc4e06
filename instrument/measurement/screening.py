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
from instrument.measurement.slips import Change, Segment, Slips, in_step_again, moved_back, slips_of
from instrument.measurement.stuck_counts import saturated, stuck_counts
from instrument.measurement.suspects import suspects
from instrument.measurement.wild_counts import wild_counts
from instrument.measurement.wiring import Wiring, rewired, wiring_of
from instrument.recording import Recording
from instrument.schemes import Scheme, scheme_of
from protocols import Floats, Mask

_DIGITS: Final = 1e-6
"""Noise that is assumed at least, over the largest value."""

HIGHEST_VALUE: Final = 1e15
"""Highest count, or light, that is believed: beyond it whole counts are not whole any more in double precision."""

_LISTED: Final = 5
"""Places that a sentence lists."""

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
    findings += _tell_impossible(recording, impossible)

    stuck = stuck_counts(values, photon_counts=recording.photon_counts)
    values[stuck] = np.nan
    findings += [
        *_tell_stuck(stuck),
        *_tell_saturated(values, saturated(values, photon_counts=recording.photon_counts)),
    ]

    dark = dark_frames(values @ scheme.light_weights, photon_counts=recording.photon_counts)
    values[dark] = np.nan
    findings += _tell_dark(dark)

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
        findings += _tell_strange(slips.sure)
        values[~slips.sure] = np.nan
    findings += _tell_wild(wild)
    values[wild] = np.nan
    light[np.isnan(values)] = np.nan

    # The frame that is all on may be the first one, near which a shift from the start is not sure.
    seen = light.copy()
    seen[:1] = np.where(np.isfinite(light[:1]), light[:1], likely[:1])
    if (
        doubtful
    ):  # all values may be of other patterns: path and image will tell, so the wiring is not judged by any frame
        seen[:] = np.nan
    wiring, frames, share = wiring_of(seen, variance, scheme, recording.plan.image_size)
    findings += _tell_wiring(wiring, tuple(frames.tolist()), share)
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


def _tell_impossible(recording: Recording, impossible: Mask) -> list[Finding]:
    if not impossible.any():
        return []
    values = recording.values[impossible]
    believed = np.abs(values) <= HIGHEST_VALUE
    kinds = {
        "not a number": int(np.isnan(values).sum()),
        "infinite": int(np.isinf(values).sum()),
        f"beyond {HIGHEST_VALUE:g}": int((np.isfinite(values) & ~believed).sum()),
        "negative": int((believed & (values < 0)).sum()),
        "not whole": int((believed & (values >= 0)).sum()),
    }
    what = ", ".join(f"{number} {kind}" for kind, number in kinds.items() if number)
    text = f"{_number(values.size, 'impossible count')} masked ({what}): {_places(impossible)}"
    return [
        Finding(
            "impossible counts",
            _frames(np.asarray(impossible.any(axis=1), bool)),
            text,
            f"{text}; look at the counter, and at whoever wrote the file",
        )
    ]


def _tell_stuck(stuck: Mask) -> list[Finding]:
    if not stuck.any():
        return []
    frames = np.asarray(stuck.any(axis=1), bool)
    text = f"{_number(int(stuck.sum()), 'equal value')} in a row masked: frames {_spans(frames)}"
    why = "a detector that is saturated, or a counter that hangs"
    return [Finding("stuck counts", _frames(frames), text, f"{text} ({why})")]


def _tell_saturated(values: Floats, highest: Mask) -> list[Finding]:
    if not highest.any():
        return []
    text = f"{np.count_nonzero(highest)} values are {values[highest][0]:g}, and none is higher"
    why = "the detector saturates at bright patterns, so that path and image may be wrong: lower the light"
    return [Finding("stuck counts", _frames(np.asarray(highest.any(axis=1), bool)), text, f"{text}: {why}")]


def _tell_dark(dark: Mask) -> list[Finding]:
    if not dark.any():
        return []
    frames = _frames(dark)
    text = f"{_number(len(frames), 'frame')} without light masked: {_spans(dark)}"
    why = "no object in the field, a shutter, or a lamp that was off"
    return [Finding("no light", frames, text, f"{text} ({why})")]


def _tell_wild(wild: Mask) -> list[Finding]:
    if not wild.any():
        return []
    text = f"{_number(int(wild.sum()), 'wild count')} masked: {_places(wild)}"
    why = "single values that neither motion nor lamp explains: look for pick-up on the pulse line, or afterpulses"
    return [Finding("wild counts", _frames(np.asarray(wild.any(axis=1), bool)), text, f"{text} ({why})")]


def _tell_strange(goes: Mask) -> list[Finding]:
    """Tell of frames that go with none of their neighbours, though no single value is wild."""
    if goes.all():
        return []
    frames = _frames(~goes)
    text = f"{_number(len(frames), 'frame')} masked beside ones that go with no neighbour: {_listed(frames)}"
    why = "as after a sync edge lost and one gained, or a jump of the object"
    return [Finding("shifted patterns", frames, text, f"{text} ({why})")]


def tell_slips(slips: Slips) -> list[Finding]:
    """Give a sentence for the shifts of a run; none where nothing slipped."""
    if not slips.any:
        return []
    parts: list[str] = []
    before = 0
    for segment in slips.segments:
        if segment.shift != before or segment.shift:
            since = f"from pattern {segment.first_pattern}{_within(segment)} of frame {segment.first_frame} on"
            since = "from the first frame on" if segment.first_frame == 0 else since
            parts.append(f"{_by(segment.shift)} {since} ({_cause(segment.shift - before)})")
        before = segment.shift
    text = "values come " + ", ".join(parts[:_LISTED]) + (", ..." if len(parts) > _LISTED else "")
    unsure = int(np.count_nonzero(~slips.sure))
    frames = _frames((slips.shift != 0) | ~slips.sure)
    return [
        Finding(
            "shifted patterns",
            frames,
            text,
            f"{text}: values that are sure are moved back, {_number(unsure, 'frame')} near a change or not sure masked; "
            "look at the sync line",
        )
    ]


def _within(segment: Segment) -> str:
    """Say which patterns it may be where they are several."""
    first, last = segment.within or (segment.first_pattern, segment.first_pattern)
    return "" if first == last else f" ({first} to {last})"


def _by(shift: int) -> str:
    return "in step again" if not shift else f"{'late' if shift > 0 else 'early'} by {_number(abs(shift), 'pattern')}"


def _cause(change: int) -> str:
    edges = "a sync edge" if abs(change) == 1 else f"{abs(change)} sync edges"
    verb = "was" if abs(change) == 1 else "were"
    return f"{edges} {verb} {'gained' if change > 0 else 'lost'}"


def _tell_wiring(wiring: Wiring, frames: tuple[int, ...], share: float) -> list[Finding]:
    if wiring == "as planned":
        return []
    saw = f"the all-on pattern gives H+/S = {share:.2f}"
    if wiring == "H- first":
        text = "H- comes first: exchanged"
        why = "H+ and H- are exchanged here; load the patterns in the planned order, or swap them on the modulator"
    else:
        text = "the modulator inverts its pictures: each value taken as S - I"
        why = "each value is taken as S - I here; set the modulator's inversion (simulated: mirrors_inverted) the other way"
    return [Finding("wiring", frames, text, f"{saw}: {text.split(':')[0]}; {why}")]


def _frames(which: Mask) -> tuple[int, ...]:
    return tuple(np.flatnonzero(which).tolist())


def _places(which: Mask) -> str:
    places = [f"frame {frame} column {column}" for frame, column in np.argwhere(which)[:_LISTED].tolist()]
    return ", ".join(places) + (", ..." if np.count_nonzero(which) > _LISTED else "")


def _spans(frames: Mask) -> str:
    """List the first and the last frame of each row of frames."""
    ends = np.flatnonzero(np.diff(frames.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    spans = [f"{first} to {end - 1}" for first, end in ends[:_LISTED].tolist()]
    return ", ".join(spans) + (", ..." if len(ends) > _LISTED else "")


def _listed(frames: tuple[int, ...]) -> str:
    return ", ".join(str(frame) for frame in frames[:_LISTED]) + (", ..." if len(frames) > _LISTED else "")


def _number(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
