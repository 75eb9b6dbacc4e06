"""What an analysis left in the file of its recording: path and image as arrays."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from instrument.frame_times import frame_middle_s
from instrument.storage import layout
from instrument.storage.hdf5 import Group
from instrument.storage.reader import opened_recording, plan_of
from protocols import Floats
from protocols.plain_file import path_of

_REFERENCE: Final = "analysis/track/reference_frame"


@dataclass(frozen=True, eq=False)
class StoredAnalysis:
    """Arrays of ``/entry/analysis``; None where the analysis found none."""

    time_s: Floats
    """``(frames,)``: middle of each frame after the first edge."""

    displacement_px: Floats | None
    """``(frames, 2)``: x, y relative to ``reference_frame``; NaN where not tracked."""

    sigma_px: Floats | None
    """``(frames, 2)``: its standard uncertainty."""

    displacement_mm: Floats | None
    """``(frames, 2)``: along the stage's axis and across it; None without a calibration too."""

    sigma_mm: Floats | None
    """``(frames, 2)``: its standard uncertainty."""

    angle_deg: Floats | None
    """``(frames,)``: angle since ``reference_frame``, clockwise in the picture."""

    angle_sigma_deg: Floats | None
    """``(frames,)``: its standard uncertainty."""

    magnification: Floats | None
    """``(frames,)``: size over that at ``reference_frame``."""

    magnification_sigma: Floats | None
    """``(frames,)``: its standard uncertainty."""

    image: Floats | None
    """``(rows, columns)``: the image at ``reference_frame``, row = y (down). Of an object that passes by it may reach outside the
    field: ``origin_px`` says where the field begins."""

    still: Floats | None
    """``(rows, columns)``: image of what stands still."""

    reference_frame: int = 0
    """Frame that displacements are relative to, and that the image shows; 0 in older files, which do not say it."""

    origin_px: tuple[int, int] = (0, 0)
    """Column and row of ``image``, in px of the patterns, at which the field's pixel (0, 0) is."""


def stored_analysis(path: str | Path) -> StoredAnalysis | None:
    """Read the arrays of the analysis; None where the recording has none. No values are read.

    Raises:
        InputError: as ``open_recording``.
    """
    path = path_of(path)
    with opened_recording(path) as entry:
        if "analysis" not in entry:
            return None
        frames = entry.shape(layout.VALUES)[0]
        frame_time_s = plan_of(path, entry).patterns_per_frame * entry.number(layout.PICTURE_TIME_S)
        return StoredAnalysis(
            time_s=frame_middle_s(frames, frame_time_s),
            displacement_px=_array(entry, "track/displacement_px"),
            sigma_px=_array(entry, "track/sigma_px"),
            displacement_mm=_array(entry, "track/displacement_mm"),
            sigma_mm=_array(entry, "track/sigma_mm"),
            angle_deg=_array(entry, "track/angle_deg"),
            angle_sigma_deg=_array(entry, "track/angle_sigma_deg"),
            magnification=_array(entry, "track/magnification"),
            magnification_sigma=_array(entry, "track/magnification_sigma"),
            image=_array(entry, "image/image"),
            still=_array(entry, "background/background"),
            origin_px=_origin(entry),
            reference_frame=int(entry.number(_REFERENCE)) if _REFERENCE in entry else 0,
        )


def _origin(entry: Group) -> tuple[int, int]:
    found = _array(entry, "image/origin_px")
    return (0, 0) if found is None else (int(found[0]), int(found[1]))


def _array(entry: Group, name: str) -> Floats | None:
    name = f"analysis/{name}"
    return np.asarray(entry.array(name), np.float64) if name in entry else None
