"""A recording of ours, made of what another program has measured."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from pydantic import ValidationError

from instrument.config import settings_of
from instrument.foreign.pairs import HadamardPairs, by_frame, in_an_order
from instrument.plan import Plan
from instrument.storage import RecordingWriter
from protocols import InputError
from protocols.plain_file import path_of

STANDS_IN_S: Final = 1e-3
"""Picture time of a recording whose source does not tell any: it is told as missing."""


@dataclass(frozen=True)
class Converted:
    """What became of a measurement by another program."""

    path: Path
    """The recording."""

    frames: int
    """Frames in it."""

    frames_measured: int
    """Of those, frames that the source has a pair of values for."""

    missing: tuple[str, ...]
    """What a recording has that the source has not, in sentences."""


def convert(
    found: HadamardPairs, out: str | Path, *, picture_time_s: float | None = None, overwrite: bool = False
) -> Converted:
    """Write a measurement as a recording by the scheme ``hadamard``. It is a whole recording: it can be checked and analysed.

    Args:
        found: what was read.
        out: the recording to write.
        picture_time_s: time from one pattern to the next, in place of what the source tells.
        overwrite: whether an existing recording may be lost.

    Raises:
        InputError: ``out`` exists or cannot be written; the picture time is none; a pattern does not exist.
    """
    order, frames = in_an_order(found)
    values, valid = by_frame(frames, found.values)
    told_s = picture_time_s if picture_time_s is not None else found.picture_time_s
    time_s = STANDS_IN_S if told_s is None else told_s
    missing = list(found.missing)
    if told_s is None:
        missing.append(f"the picture time is not known: {STANDS_IN_S * 1e6:g} us stand for it (--picture-time-us)")
    if order is None:
        missing.append("the patterns were shown in an order of their own: frames stand in the order tv, not in time")
    if not valid.all():
        missing.append(f"{int(np.count_nonzero(~valid))} of {len(valid)} frames were not measured, and are masked")
    missing.append("no raw counts, no edge times, no timing audit, no stage: what happened in time cannot be verified")
    try:
        plan = Plan(
            frames=len(values),
            image_size=found.image_size,
            superpixel=1,
            pattern_rate_hz=1 / time_s,
            scheme=settings_of({"name": "hadamard", "hadamard_order": order or "tv"}),
            run=found.about,
        )
    except ValidationError as error:
        raise InputError(
            saw=f"{len(values)} patterns of {found.image_size} x {found.image_size} px, {time_s:g} s each",
            expected="a measurement that a plan of ours could have asked for",
            remedy=f"it cannot: {error.errors()[0]['msg']}",
        ) from error
    bench = json.dumps({"converted": {**found.origin, "missing": missing}})
    path = path_of(out)
    with RecordingWriter(path, plan, picture_time_s=time_s, bench=bench, overwrite=overwrite) as writer:
        writer.append(values.ravel())
        writer.finish(frame_valid=valid)
    return Converted(path, len(values), int(np.count_nonzero(valid)), tuple(missing))
