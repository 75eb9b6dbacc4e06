"""What tracking and reconstruction found, written into the recording they were made from."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from instrument.storage.edit import refuse_unchangeable, rewritten
from instrument.storage.hdf5 import Group
from instrument.storage.json_text import json_text
from instrument.storage.provenance import PROGRAM, now, program_version
from instrument.storage.reader import open_recording
from protocols import Floats, Integers


def write_analysis(
    path: str | Path,
    *,
    displacement_px: Floats | None,
    image: Floats | None,
    sigma_px: Floats | None = None,
    angle_deg: Floats | None = None,
    angle_sigma_deg: Floats | None = None,
    magnification: Floats | None = None,
    magnification_sigma: Floats | None = None,
    pivot_px: Floats | None = None,
    start_px: Floats | None = None,
    start_sigma_px: Floats | None = None,
    reference_frame: int = 0,
    displacement_mm: Floats | None = None,
    sigma_mm: Floats | None = None,
    image_grid: int | None = None,
    origin_px: tuple[int, int] = (0, 0),
    still: Floats | None = None,
    window_images: Floats | None = None,
    window_frames: Integers | None = None,
    table: Mapping[str, Any] | None = None,
    settings: Mapping[str, Any] | None = None,
    into: str | Path | None = None,
) -> None:
    """Write ``/entry/analysis`` and make its image the default plot. An earlier analysis is replaced; raw data stay as they are.

    All or nothing: if it fails, the file is as it was before. A copy of the recording, with the analysis, takes its place, so
    that whoever has it open keeps the old one. Permissions, owner and extended attributes stay, and a link to the recording
    stays a link. What ``edit.refuse_unchangeable`` names is refused.

    Args:
        path: the recording.
        displacement_px: ``(frames, 2)`` x, y relative to ``reference_frame``; NaN where not tracked; None where the scheme sees
            no position.
        image: ``(rows, columns)`` the reconstructed image at ``reference_frame``, row = y (down), column = x; None where the
            scheme only tracks. It covers the whole field, whatever the number of its pixels, or more.
        sigma_px: ``(frames, 2)`` standard uncertainty of ``displacement_px``.
        angle_deg: ``(frames,)`` angle since that frame, clockwise in the picture; NaN where unknown; None where not measured.
        angle_sigma_deg: ``(frames,)`` its standard uncertainty.
        magnification: ``(frames,)`` size over that in that frame; NaN where unknown; None where it was not found to change.
        magnification_sigma: ``(frames,)`` its standard uncertainty.
        pivot_px: ``(2,)`` x, y at that frame of the point about which the object turns and grows; None where it does neither.
        start_px: ``(2,)`` x, y of the object's centroid at frame 0, in px of the field; None where it was not measured.
        start_sigma_px: ``(2,)`` its standard uncertainty.
        reference_frame: frame that displacements, angles and magnifications are relative to, and that the image shows.
        displacement_mm: ``(frames, 2)`` along the stage's axis and across it, relative to that frame; None without a calibration.
        sigma_mm: ``(frames, 2)`` standard uncertainty of ``displacement_mm``.
        image_grid: pixels of ``image`` that a pattern pixel has along each axis; None where it covers the field and no more.
        origin_px: column and row of ``image``, in px of the patterns, at which the field's pixel (0, 0) is.
        still: ``(rows, columns)`` image of what stands still, likewise; None where none was found.
        window_images: ``(n, rows, columns)`` an image like ``image`` for each of some windows of the run; None for none.
        window_frames: ``(n, 2)`` first frame of each window, and the frame after its last one.
        table: figures to print, by name; stored as JSON.
        settings: how the analysis was done; stored as JSON.
        into: a new file, to leave the recording as it is: a copy with the analysis goes there. None writes into the recording.

    Raises:
        InputError: ``path`` is no readable recording, is being recorded now, or may not be changed; ``into`` is there already.
        ValueError: arrays whose shapes do not go with the recording.
    """
    path, copy = Path(path), None if into is None else Path(into)
    refuse_unchangeable(path, copy)
    recording = open_recording(path)
    frames, size = len(recording), recording.plan.image_size
    paths = {
        "displacement_px": displacement_px,
        "sigma_px": sigma_px,
        "displacement_mm": displacement_mm,
        "sigma_mm": sigma_mm,
    }
    for name, rows in paths.items():
        if rows is not None and rows.shape != (frames, 2):
            raise ValueError(f"{name} of shape {rows.shape} for {frames} frames")
    if image is not None and image.ndim != 2:
        raise ValueError(f"an image of shape {image.shape}")
    arrays = [array for array in (*paths.values(), image, window_images) if array is not None]
    texts = json_text(table or {}), json_text(settings or {})
    sides = () if image is None else image.shape
    more_bytes = 8 * (sum(array.size for array in arrays) + sum(sides)) + sum(len(text) for text in texts)
    with rewritten(path, copy, more_bytes=more_bytes) as entry:
        analysis = entry.group("analysis", "NXprocess", default="track" if image is None else "image")
        analysis.add("program", PROGRAM)
        analysis.add("version", program_version())
        analysis.add("date", now())
        analysis.add("table", texts[0])
        analysis.add("settings", texts[1])
        if displacement_px is not None:
            _add_track(
                analysis,
                displacement_px,
                reference_frame,
                [
                    ("sigma_px", sigma_px, "px", None),
                    ("angle_deg", angle_deg, "degree", f"turn since frame {reference_frame}, from x to y"),
                    ("angle_sigma_deg", angle_sigma_deg, "degree", None),
                    ("magnification", magnification, None, f"size over that at frame {reference_frame}"),
                    ("magnification_sigma", magnification_sigma, None, None),
                    (
                        "pivot_px",
                        pivot_px,
                        "px",
                        f"x, y at frame {reference_frame} of the point whose displacement it is",
                    ),
                    ("start_px", start_px, "px", "x, y of the centroid at frame 0 in the field"),
                    ("start_sigma_px", start_sigma_px, "px", None),
                    (
                        "displacement_mm",
                        displacement_mm,
                        "mm",
                        f"along the stage's axis and across it, relative to frame {reference_frame}",
                    ),
                    ("sigma_mm", sigma_mm, "mm", None),
                ],
            )
        if image is not None:
            picture = analysis.group("image", "NXdata", signal="image", axes=["y_px", "x_px"])
            picture.add("image", image, long_name=f"image at frame {reference_frame}")
            pixel_px = size / len(image) if image_grid is None else 1 / image_grid
            _add_axes(picture, image.shape, pixel_px, origin_px)
            if pixel_px * max(image.shape) > size:
                picture.add(
                    "origin_px", np.array(origin_px, np.int64), long_name="column, row of the field's pixel (0, 0)"
                )
        if window_images is not None and window_frames is not None:
            _add_windows(analysis, window_images, window_frames, size)
        if still is not None:
            picture = analysis.group("background", "NXdata", signal="background", axes=["y_px", "x_px"])
            picture.add("background", still, long_name="image of what stands still")
            _add_axes(picture, still.shape, size / len(still))
        entry.set_attributes(default="analysis")


def _add_track(
    analysis: Group,
    displacement_px: Floats,
    reference_frame: int,
    others: Iterable[tuple[str, Floats | None, str | None, str | None]],
) -> None:
    """Give the path, and of the others (name, array, unit, long name) those that there are."""
    track = analysis.group("track", "NXdata", signal="displacement_px", axes=[".", "."])
    track.add("displacement_px", displacement_px, units="px", long_name=f"x, y relative to frame {reference_frame}")
    track.add("reference_frame", reference_frame)
    for name, array, units, long_name in others:
        if array is not None:
            attributes = {"units": units, "long_name": long_name}
            track.add(name, array, **{key: text for key, text in attributes.items() if text is not None})


def _add_windows(analysis: Group, images: Floats, frames: Integers, size: int) -> None:
    """Give the image of each window, and which frames it is from."""
    pictures = analysis.group("windows", "NXdata", signal="image", axes=[".", "y_px", "x_px"])
    pictures.add("image", images, long_name="image at frame 0, from the frames of each window")
    pictures.add("frames", frames, long_name="first frame of each window, and the one after its last")
    _add_axes(pictures, images[0].shape, size / len(images[0]))


def _add_axes(picture: Group, shape: tuple[int, ...], pixel_px: float, origin_px: tuple[int, int] = (0, 0)) -> None:
    """Give the middles of the image's rows and columns, in px of the patterns: row 0 of the patterns has its middle at 0."""
    for name, count, first_px in zip(("y_px", "x_px"), shape, origin_px[::-1], strict=True):
        middle_px = (np.arange(count) + 0.5) * pixel_px - 0.5 - first_px
        picture.add(name, np.asarray(middle_px, np.float64), units="px")
    picture.add("pixel_px", pixel_px, units="px")
