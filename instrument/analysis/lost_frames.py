"""Frames that were lost as a whole: path and position values stay right, and the image gets worse."""

from dataclasses import replace
from typing import Final

from instrument.analysis.find import NOTHING, Found
from instrument.analysis.otherwise import squares_of
from instrument.analysis.second_look import Find
from instrument.measurement import Finding, Measurement, after_lost_frame

_BETTER: Final = 25.0
"""Fall of the sum of squares of the Hadamard values from which on a lost frame is believed: without one it rises."""

_MOST_LOST: Final = 3
"""Frames lost that are looked for."""


def without_lost_frames(measurement: Measurement, found: Found, find: Find) -> Found:
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
        except NOTHING:  # too little is left of the run
            return found
        if not squares_of(alike) - squares_of(again) > _BETTER:
            return found
        measurement, found = moved, again
    return found
