"""A run as it would be were its fringes wired otherwise, or all its values a pattern late or early, and what then explains it.

The image is made of Hadamard values and shows where the object is. The path is made of position values. Where the fringes are
wired otherwise than planned, or all values stand at the pattern before or after their own, each may look well by itself, but the
position values are not those of the image's object.

Such a run is looked at as it would be were it otherwise, in each of a few ways: quickly in all of them, and in full in those
that look likeliest. One of them is believed where it explains far more, and where the image alone does not speak against it.
"""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Final

import numpy as np

from instrument.analysis.find import NOTHING, Found
from instrument.analysis.second_look import Find, Screen, slipped_unseen
from instrument.joint import CONTRADICTS, position_misfit
from instrument.measurement import Finding, Measurement, by_patterns, first_light
from instrument.schemes import AXES_EXCHANGED, exchanges
from instrument.tracking import track

MAY_CONTRADICT: Final = 1.1
"""Misfit of the position values above which they may contradict the image: at 50 counts of an all-on pattern, healthy runs had
up to 1.12, and fringes that were exchanged 1.14 or more."""

_BLURRED: Final = 1.02
"""Misfit of the final image above which it may be blurred by the path of the other axis: at 50 counts exchanged axes near the
diagonal left 1.026 and more, and healthy runs 0.99 +- 0.02."""

_IN_FULL: Final = 2
"""Explanations, the likeliest ones, along which path and image are found in full."""

_AS_LIKELY: Final = 2.0
"""Squared misfit beyond that of noise, over that of the likeliest one, up to which another looks as likely."""

_FAR_BETTER: Final = 0.5
"""What an explanation may leave of the squared misfit beyond that of noise, over what is left without it."""

_AS_CLEAR: Final = 0.02
"""Misfit of the Hadamard values by which the image may be worse all the same: the path of wrong fringes blurs it."""

_FAR_CLEARER: Final = 50.0
"""Fall of the sum of squares of the Hadamard values from which on the image alone says so."""


def otherwise(
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
        if not found.position_misfit > MAY_CONTRADICT or not (first := _misfit(measurement)) > MAY_CONTRADICT:
            blurred = found.reconstruction is not None and found.reconstruction.misfit > _BLURRED
            return _axes_exchanged(measurement, found, find) if blurred and np.isfinite(left) else None
        left = min(left, first**2 - 1)
    best = _best_of(_likely(measurement, first), found, left, find)
    if best is not None and best[0].scheme is not measurement.scheme:  # fringes are exchanged: no slip looks like that
        return best
    slipped, sure = slipped_unseen(measurement, screen)
    by_slip: tuple[Measurement, Found] | None = None
    if slipped is not None:
        with suppress(*NOTHING):
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
    most = _AS_LIKELY * max(looked_at[0][0] ** 2 - 1, MAY_CONTRADICT**2 - 1)
    return [other for misfit, _, other in looked_at if misfit < first and misfit**2 - 1 <= most]


def _axes_exchanged(measurement: Measurement, found: Found, find: Find) -> tuple[Measurement, Found] | None:
    """Give the run with the axes exchanged, if position values and image agree by that too, and the image is far clearer."""
    likely = (
        other
        for other in _explanations(measurement)
        if other.findings and other.findings[-1].text == AXES_EXCHANGED and _misfit(other) < MAY_CONTRADICT
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
    best, best_left, agreeing = None, np.inf, MAY_CONTRADICT**2 - 1
    for other in others:
        try:
            by_other = find(other)
        except NOTHING:
            continue
        other_left = by_other.position_misfit**2 - 1
        if not other_left < min(max(left, agreeing), best_left, CONTRADICTS**2 - 1):
            continue
        far_better = left > agreeing and other_left < _FAR_BETTER * left
        as_clear = found is None or by_other.usual_misfit < found.usual_misfit + _AS_CLEAR
        far_clearer = found is not None and squares_of(found) - squares_of(by_other) > _FAR_CLEARER
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
    except NOTHING:
        return np.inf


def squares_of(found: Found) -> float:
    """Sum of squares that the image leaves of the Hadamard values, in units of their noise."""
    return float(np.count_nonzero(found.measurement.valid) * found.usual_misfit**2)
