"""Path and image of a run, and where they contradict each other, by the likeliest explanation of that.

The image is made of Hadamard values and shows where the object is. The path is made of position values. Where the fringes are
wired otherwise than planned, or all values stand at the pattern before or after their own, each may look well by itself, but the
position values are not those of the image's object. A frame that was lost as a whole leaves path and positions right, and makes
the image worse.

Such a run is looked at again as it would be were it otherwise, in each of a few ways: roughly in all of them, and in full in
those that look best. One of them is believed where it explains far more, and where the image alone does not speak against it.
Where none is, the contradiction is told.
"""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Final

import numpy as np

from instrument.analysis.doubts import vague_px
from instrument.analysis.find import Found
from instrument.analysis.second_look import Find, Screen, placed_again, slipped_for_sure, slipped_unseen
from instrument.joint import CONTRADICTS, position_misfit
from instrument.measurement import Finding, Measurement, after_lost_frame, by_patterns, first_light
from instrument.schemes import AXES_EXCHANGED, exchanges
from instrument.tracking import track
from protocols import InputError

_NOTHING: Final = (InputError, np.linalg.LinAlgError)
"""Errors of a run in which nothing is found."""

_CONTRADICT: Final = 1.1
"""Misfit of the position values above which they may contradict the image: at 50 counts of an all-on pattern, healthy runs had
up to 1.12, and fringes that were exchanged 1.14 or more."""

_BLURRED: Final = 1.03
"""Misfit of the Hadamard values above which the image may be blurred by the path of the other axis."""

_IN_FULL: Final = 2
"""Explanations, the likeliest ones, along which path and image are found in full."""

_FAR_BETTER: Final = 0.5
"""What an explanation may leave of the squared misfit beyond that of noise, over what is left without it."""

_AS_LIKELY: Final = 2.0
"""Squared misfit beyond that of noise, over that of the likeliest one, up to which another looks as likely."""

_AS_CLEAR: Final = 0.02
"""Misfit of the Hadamard values by which the image may be worse all the same: the path of wrong fringes blurs it."""

_FAR_CLEARER: Final = 50.0
"""Fall of the sum of squares of the Hadamard values from which on the image alone says so."""

_UNEXPLAINED: Final = 1.1
"""Misfit of the Hadamard values above which values may have slipped though the position values agree with the image,"""

_BRIGHT: Final = 10.0
"""and above which there is so much light that the counts themselves tell every slip."""

_BETTER: Final = 25.0
"""Fall of the sum of squares of the Hadamard values from which on a lost frame is believed: without one it rises."""

_MOST_LOST: Final = 3
"""Frames lost that are looked for."""


def explained(measurement: Measurement, find: Find, screen: Screen) -> Found:
    """Find path and image, and mend what the two show to be wrong; see the module.

    Args:
        measurement: of a run, before anything was found in it.
        find: function that finds path and image by it.
        screen: function that gives the run whose values came by some shifts.

    Raises:
        InputError, LinAlgError: as ``find``, where no explanation helps.
    """
    found, refused = None, None
    try:
        found = find(measurement)
    except _NOTHING as error:
        refused = error
    as_planned = found
    better = _otherwise(measurement, found, find, screen)
    agree = found is not None and found.position_misfit <= _CONTRADICT
    if better is None and found is not None and agree and _UNEXPLAINED < found.usual_misfit < _BRIGHT:
        slipped = slipped_for_sure(measurement, screen)
        with suppress(*_NOTHING):
            better = None if slipped is None else (slipped, find(slipped))
    if better is not None:
        measurement, found = better
    if found is None:
        assert refused is not None  # noqa: S101  (either is there)
        raise refused
    measurement, found = placed_again(measurement, found, find, screen)
    found = _without_lost_frames(measurement, found, find)
    if as_planned is not None and _vaguer(found, as_planned):
        found = as_planned
    return _doubted(found)


def _vaguer(found: Found, as_planned: Found) -> bool:
    """Whether a path may be off by whole periods, and by more than the one as planned: what led to it is not believed."""
    of_found, before = (vague_px(one.measurement, one.trajectory) for one in (found, as_planned))
    return of_found is not None and found is not as_planned and (before is None or before < of_found)


def _doubted(found: Found) -> Found:
    """Say where position values and image still contradict each other."""
    misfit = found.position_misfit
    if not misfit > CONTRADICTS:
        return found
    text = "the position values are not those of the image's object"
    why = (
        f"{text}: on the path found they are off by {misfit:.3g} times their noise, so that the path may be wrong by more than "
        "is stated; look at the order of the patterns, at light that only some of them see, or take more light"
    )
    frames = tuple(range(len(found.measurement)))
    findings = (*found.measurement.findings, Finding("contradiction", frames, text, why))
    return replace(found, measurement=replace(found.measurement, findings=findings))


def _without_lost_frames(measurement: Measurement, found: Found, find: Find) -> Found:
    """Move back what comes after a frame that was lost, as often as one is seen."""
    for _ in range(_MOST_LOST):
        lost = found.lost_frame
        if lost is None or found.reconstruction is None:
            return found
        moved = after_lost_frame(measurement, lost.frame, lost.first, lost.last)
        text = f"a whole frame was lost at frame {lost.first}" + (f" to {lost.last}" if lost.last > lost.first else "")
        frames = tuple(range(lost.first, max(lost.last, lost.frame) + 1))
        how = "what comes after is moved one frame later, and frames in doubt are masked; look at the counter and the sync line"
        moved = replace(moved, findings=(*moved.findings, Finding("shifted patterns", frames, text, f"{text}: {how}")))
        masked = measurement.valid.copy()
        masked[list(frames)] = False
        try:
            again, alike = find(moved), find(replace(measurement, valid=masked))  # of as many values, but for one
        except _NOTHING:  # too little is left of the run
            return found
        if not _squares(alike) - _squares(again) > _BETTER:
            return found
        measurement, found = moved, again
    return found


def _squares(found: Found) -> float:
    """Sum of squares that the image leaves of the Hadamard values, in units of their noise."""
    return float(np.count_nonzero(found.measurement.valid) * found.usual_misfit**2)


def _otherwise(
    measurement: Measurement, found: Found | None, find: Find, screen: Screen
) -> tuple[Measurement, Found] | None:
    """Give the run as it would be by the explanation that makes position values and image agree; None where none does.

    Args:
        measurement: as planned.
        found: path and image as planned; None where none were found.
        find: function that finds path and image.
        screen: function that gives the run whose values came by some shifts.
    """
    left, first = np.inf, np.inf
    if found is not None:
        left = found.position_misfit**2 - 1
        if not found.position_misfit > _CONTRADICT or not (first := _misfit(measurement)) > _CONTRADICT:
            return (
                _axes_exchanged(measurement, found, find) if left < np.inf and found.usual_misfit > _BLURRED else None
            )
        left = min(left, first**2 - 1)
    best = _best_of(_likely(measurement, first), found, left, find)
    if best is not None and best[0].scheme is not measurement.scheme:  # fringes are exchanged: no slip looks like that
        return best
    slipped, sure = slipped_unseen(measurement, screen)
    by_slip: tuple[Measurement, Found] | None = None
    if slipped is not None:
        with suppress(*_NOTHING):
            by_slip = (slipped, find(slipped)) if sure else _best_of([slipped], found, left, find)
    known = (one for one in (best, by_slip) if one is not None)
    return min(known, key=lambda one: one[1].position_misfit, default=None)


def _likely(measurement: Measurement, first: float) -> list[Measurement]:
    """Give the explanations that look likeliest: few, and none that explains less than the run as planned.

    Args:
        measurement: as planned.
        first: misfit of its position values at a quick look; infinite where nothing was found.
    """
    looked_at = sorted((_misfit(other), k, other) for k, other in enumerate(_explanations(measurement)))[:_IN_FULL]
    most = _AS_LIKELY * max(looked_at[0][0] ** 2 - 1, _CONTRADICT**2 - 1)
    return [other for misfit, _, other in looked_at if misfit < first and misfit**2 - 1 <= most]


def _axes_exchanged(measurement: Measurement, found: Found, find: Find) -> tuple[Measurement, Found] | None:
    """Give the run with the axes exchanged, if position values and image agree by that too, and the image is far clearer."""
    likely = (
        other
        for other in _explanations(measurement)
        if other.findings and other.findings[-1].text == AXES_EXCHANGED and _misfit(other) < _CONTRADICT
    )
    return _best_of(likely, found, found.position_misfit**2 - 1, find)


def _best_of(
    others: Iterable[Measurement], found: Found | None, left: float, find: Find
) -> tuple[Measurement, Found] | None:
    """Give the explanation by which least is left of the position values, if it explains far more.

    Args:
        others: the run as it would be by each.
        found: path and image as planned; None where none were found.
        left: squared misfit of the position values beyond that of noise, as planned.
        find: function that finds path and image.
    """
    best, best_left, agreeing = None, np.inf, _CONTRADICT**2 - 1
    for other in others:
        try:
            by_other = find(other)
        except _NOTHING:
            continue
        other_left = by_other.position_misfit**2 - 1
        if not other_left < min(max(left, agreeing), best_left, CONTRADICTS**2 - 1):
            continue
        far_better = left > agreeing and other_left < _FAR_BETTER * left
        as_clear = found is None or by_other.usual_misfit < found.usual_misfit + _AS_CLEAR
        far_clearer = found is not None and _squares(found) - _squares(by_other) > _FAR_CLEARER
        if (far_better and as_clear) or far_clearer:
            best, best_left = (other, by_other), other_left
    return best


def _explanations(measurement: Measurement) -> Iterator[Measurement]:
    """Give the run as it would be in each of a few other ways, with the finding that this were."""
    frames = tuple(range(len(measurement)))
    for text, scheme in exchanges(measurement.scheme).items():
        why = f"{text}: taken so here; load the patterns in the planned order, or exchange them on the modulator"
        findings = (*measurement.findings, Finding("wiring", frames, text, why))
        yield replace(measurement, scheme=scheme, findings=findings)
    for patterns in (1, -1):
        text = f"all values come one pattern {'late' if patterns > 0 else 'early'}"
        why = f"{text}: moved back here; look at the sync line, and at the first edge of the run"
        findings = (*measurement.findings, Finding("shifted patterns", frames, text, why))
        yield replace(by_patterns(measurement, patterns), findings=findings)


def _misfit(measurement: Measurement) -> float:
    """Misfit of the position values along the path that they give, infinite where there is none."""
    try:
        lit = first_light(measurement)
        return position_misfit(lit, track(lit))
    except _NOTHING:
        return np.inf
