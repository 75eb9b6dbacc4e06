"""Path and image of a run, and where they contradict each other, by the likeliest explanation of that.

The run may be wired otherwise than planned (``otherwise``), its values may have slipped though the counts do not tell
(``second_look``), or whole frames may be lost (``lost_frames``). Where nothing explains it, the contradiction is told.
"""

from contextlib import suppress
from dataclasses import replace
from typing import Final

from instrument.analysis.doubts import vague_px
from instrument.analysis.find import NOTHING, Found
from instrument.analysis.lost_frames import without_lost_frames
from instrument.analysis.otherwise import MAY_CONTRADICT, otherwise
from instrument.analysis.second_look import Find, Screen, placed_again, slipped_for_sure
from instrument.joint import CONTRADICTS
from instrument.measurement import Finding, Measurement

_UNEXPLAINED: Final = 1.1
"""Misfit of the Hadamard values above which values may have slipped though the position values agree with the image,"""

_BRIGHT: Final = 10.0
"""and above which there is so much light that the counts themselves tell every slip."""

_NO_NOISE: Final = 0.5
"""Misfit of the position values below which they have less noise than photons make, as simulated ones may: none has slipped."""


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
    except NOTHING as error:
        refused = error
    as_planned = found
    better = otherwise(measurement, found, find, screen)
    agree = found is not None and _NO_NOISE < found.position_misfit <= MAY_CONTRADICT
    if better is None and found is not None and agree and _UNEXPLAINED < found.usual_misfit < _BRIGHT:
        slipped = slipped_for_sure(measurement, screen)
        with suppress(*NOTHING):
            better = None if slipped is None else (slipped, find(slipped))
    if better is not None:
        measurement, found = better
    if found is None:
        assert refused is not None  # noqa: S101  (either is there)
        raise refused
    measurement, found = placed_again(measurement, found, find, screen)
    found = without_lost_frames(measurement, found, find)
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
        f"{text}: on the path found they are off by {misfit:.3g} times what their noise and the image's error allow, so that "
        "the path may be wrong by more than is stated; look at the order of the patterns, at light that only some of them "
        "see, or take more light"
    )
    frames = tuple(range(len(found.measurement)))
    findings = (*found.measurement.findings, Finding("contradiction", frames, text, why))
    return replace(found, measurement=replace(found.measurement, findings=findings))
