"""What tracking and reconstruction found, written into the recording they were made from."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from instrument.storage.edit import rewritten
from instrument.storage.hdf5 import open_to_read
from instrument.storage.in_use import refuse_while_written
from instrument.storage.json_text import json_text
from instrument.storage.provenance import PROGRAM, now, program_version
from instrument.storage.reader import open_recording
from protocols import Floats


def write_analysis(
    path: str | Path,
    *,
    displacement_px: Floats | None,
    image: Floats | None,
    sigma_px: Floats | None = None,
    table: Mapping[str, Any] | None = None,
    settings: Mapping[str, Any] | None = None,
) -> None:
    """Write ``/entry/analysis`` and make its image the default plot. An earlier analysis is replaced; raw data stay as they are.

    All or nothing: if it fails, the file is as it was before. A copy of the recording, with the analysis, takes its place, so
    that whoever has it open keeps the old one. A recording that is being written is refused; ``in_use.refuse_while_written``
    says what that covers.

    Args:
        path: the recording.
        displacement_px: ``(frames, 2)`` x, y relative to frame 0; NaN where not tracked; None where the scheme sees no position.
        image: ``(rows, columns)`` the reconstructed image at frame 0, row = y (down), column = x; None where the scheme only
            tracks.
        sigma_px: ``(frames, 2)`` standard uncertainty of ``displacement_px``.
        table: figures to print, by name; stored as JSON.
        settings: how the analysis was done; stored as JSON.

    Raises:
        InputError: ``path`` is no readable recording, or is being recorded now.
        ValueError: arrays whose shapes do not go with the recording.
    """
    path = Path(path)
    frames = len(open_recording(path))
    refuse_while_written(path)
    for name, rows in (("displacement_px", displacement_px), ("sigma_px", sigma_px)):
        if rows is not None and rows.shape != (frames, 2):
            raise ValueError(f"{name} of shape {rows.shape} for {frames} frames")
    if image is not None and image.ndim != 2:
        raise ValueError(f"an image of shape {image.shape}")
    with open_to_read(path) as old, rewritten(old, path) as entry:
        analysis = entry.group("analysis", "NXprocess", default="track" if image is None else "image")
        analysis.add("program", PROGRAM)
        analysis.add("version", program_version())
        analysis.add("date", now())
        analysis.add("table", json_text(table or {}))
        analysis.add("settings", json_text(settings or {}))
        if displacement_px is not None:
            track = analysis.group("track", "NXdata", signal="displacement_px", axes=[".", "."])
            track.add("displacement_px", displacement_px, units="px", long_name="x, y relative to frame 0")
            if sigma_px is not None:
                track.add("sigma_px", sigma_px, units="px")
        if image is not None:
            picture = analysis.group("image", "NXdata", signal="image", axes=["y_px", "x_px"])
            picture.add("image", image, long_name="image at frame 0")
            picture.add("y_px", np.arange(image.shape[0], dtype=np.float64), units="px")
            picture.add("x_px", np.arange(image.shape[1], dtype=np.float64), units="px")
        entry.set_attributes(default="analysis")
