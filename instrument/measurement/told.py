"""What the screening of a recording found, as findings in words."""

from typing import Final

import numpy as np

from instrument.measurement.finding import Finding
from instrument.measurement.slips import Segment, Slips
from instrument.measurement.wiring import Wiring
from instrument.recording import Recording
from protocols import Floats, Mask

HIGHEST_VALUE: Final = 1e15
"""Highest count, or light, that is believed: beyond it whole counts are not whole any more in double precision."""

_LISTED: Final = 5
"""Places that a sentence lists."""


def tell_impossible(recording: Recording, impossible: Mask) -> list[Finding]:
    """Tell of values that no detector gives; nothing where there are none."""
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


def tell_stuck(stuck: Mask) -> list[Finding]:
    """Tell of equal values in a row; nothing where there are none."""
    if not stuck.any():
        return []
    frames = np.asarray(stuck.any(axis=1), bool)
    text = f"{_number(int(stuck.sum()), 'equal value')} in a row masked: frames {_spans(frames)}"
    why = "a detector that is saturated, or a counter that hangs"
    return [Finding("stuck counts", _frames(frames), text, f"{text} ({why})")]


def tell_saturated(values: Floats, highest: Mask) -> list[Finding]:
    """Tell of values that are all the highest one; nothing where there are none."""
    if not highest.any():
        return []
    text = f"{np.count_nonzero(highest)} values are {values[highest][0]:g}, and none is higher"
    why = "the detector saturates at bright patterns, so that path and image may be wrong: lower the light"
    return [Finding("stuck counts", _frames(np.asarray(highest.any(axis=1), bool)), text, f"{text}: {why}")]


def tell_dark(dark: Mask) -> list[Finding]:
    """Tell of frames without light; nothing where there are none."""
    if not dark.any():
        return []
    frames = _frames(dark)
    text = f"{_number(len(frames), 'frame')} without light masked: {_spans(dark)}"
    why = "no object in the field, a shutter, or a lamp that was off"
    return [Finding("no light", frames, text, f"{text} ({why})")]


def tell_wild(wild: Mask) -> list[Finding]:
    """Tell of single wild values; nothing where there are none."""
    if not wild.any():
        return []
    text = f"{_number(int(wild.sum()), 'wild count')} masked: {_places(wild)}"
    why = "single values that neither motion nor lamp explains: look for pick-up on the pulse line, or afterpulses"
    return [Finding("wild counts", _frames(np.asarray(wild.any(axis=1), bool)), text, f"{text} ({why})")]


def tell_strange(goes: Mask) -> list[Finding]:
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


def tell_wiring(wiring: Wiring, frames: tuple[int, ...], share: float) -> list[Finding]:
    """Tell of patterns that were wired otherwise than planned; nothing where they were as planned.

    Args:
        wiring: how they were.
        frames: frames that show it.
        share: value of the all-on pattern H+ over the light of its pair.
    """
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
