"""Path and image of a run, and where they contradict each other, by the likeliest explanation of that.

The image is made of Hadamard values and shows where the object is. The path is made of position values. Where the fringes are
wired otherwise than planned, or all values stand at the pattern before or after their own, each may look well by itself, but the
position values are not those of the image's object. A frame that was lost as a whole leaves path and positions right, and makes
the image worse.

Such a run is looked at again as it would be were it otherwise, in each of a few ways. One of them is believed where it explains
far more.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from instrument.analysis.find import Found
from instrument.analysis.second_look import Find, Screen, placed_again, slipped_for_sure, slipped_unseen
from instrument.joint import position_misfit
from instrument.measurement import Finding, Measurement, after_lost_frame, by_patterns, first_light
from instrument.schemes import exchanges
from instrument.tracking import track
from protocols import InputError

_CONTRADICT: Final = 1.2
"""Misfit of the position values above which they are taken to contradict the image: healthy runs had 1.0 to 1.15, and fringes
that were exchanged 1.4 or more at 50 counts of an all-on pattern."""

_FAR_BETTER: Final = 0.2
"""What an explanation may leave of the squared misfit beyond that of noise, over what is left without it; or as little as
does not contradict."""

_UNEXPLAINED: Final = 1.1
"""Misfit of the Hadamard values above which values may have slipped though the position values agree with the image."""

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
        InputError: as ``find``, where no explanation helps.
    """
    found, refused, contradiction = None, None, np.inf
    try:
        found = find(measurement)
        contradiction = found.position_misfit
    except InputError as error:
        refused = error
    otherwise = _otherwise(measurement, contradiction, screen)
    if (
        otherwise is None
        and found is not None
        and not contradiction > _CONTRADICT
        and found.usual_misfit > _UNEXPLAINED
    ):
        otherwise = slipped_for_sure(measurement, screen)
    if otherwise is not None:
        try:
            measurement, found = otherwise, find(otherwise)
        except InputError as error:
            refused = error
    if found is None:
        assert refused is not None  # noqa: S101  (either is there)
        raise refused
    measurement, found = placed_again(measurement, found, find, screen)
    return _without_lost_frames(measurement, found, find)


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
        except InputError:  # too little is left of the run
            return found
        if not _squares(alike) - _squares(again) > _BETTER:
            return found
        measurement, found = moved, again
    return found


def _squares(found: Found) -> float:
    """Sum of squares that the image leaves of the Hadamard values, in units of their noise."""
    return float(np.count_nonzero(found.measurement.valid) * found.usual_misfit**2)


def _otherwise(measurement: Measurement, contradiction: float, screen: Screen) -> Measurement | None:
    """Give the run as it would be by the explanation that makes position values and image agree; None where none does.

    Args:
        measurement: as planned.
        contradiction: misfit of the position values of the run as planned; infinite where no image was found at all.
        screen: function that gives the run whose values came by some shifts.
    """
    if not contradiction > _CONTRADICT:
        return None
    tried = [(_misfit(other), other) for other in (measurement, *_explanations(measurement))]
    best = _best(tried, contradiction)
    if best is not None and best.scheme is not measurement.scheme:  # fringes are exchanged: no slip looks like that
        return best
    slipped, sure = slipped_unseen(measurement, screen)
    if slipped is None or sure:
        return slipped or best
    return _best([*tried, (_misfit(slipped), slipped)], contradiction)


def _best(tried: Sequence[tuple[float, Measurement]], contradiction: float) -> Measurement | None:
    """Give the explanation of least misfit; None where it does not explain enough, or where that is the run as planned.

    Args:
        tried: misfit of each explanation, the run as planned first.
        contradiction: as above.
    """
    misfit, other = min(tried, key=lambda one: one[0])
    left = min(contradiction, tried[0][0]) ** 2 - 1
    explains = misfit**2 - 1 < max(_FAR_BETTER * left, min(_CONTRADICT**2 - 1, left / 2))
    return other if other is not tried[0][1] and explains else None


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
    except (InputError, np.linalg.LinAlgError):
        return np.inf
