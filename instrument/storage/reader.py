"""A recording read back: whole, partial, or left behind by a program that was killed."""

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from instrument.plan import Plan
from instrument.recording import Recording, TimingReport
from instrument.storage import layout
from instrument.storage.hdf5 import HDF5_ERRORS, Group, is_hdf5, open_to_read
from instrument.storage.layout import unusable
from protocols import Floats, InputError, Mask, Truth


def open_recording(path: str | Path) -> Recording:
    """Read a recording. A run that broke, or whose program was killed, is a shorter one with a mask.

    Raises:
        InputError: no such file, no HDF5, no recording, of a later layout, truncated or damaged: says which.
    """
    path = Path(path)
    with opened_recording(path) as entry:
        return _recording(path, entry)


@contextmanager
def opened_recording(path: Path) -> Generator[Group]:
    """Open a recording and give its entry; what goes wrong while it is open is told as a file that cannot be read.

    Raises:
        InputError: as ``open_recording``.
    """
    if not path.is_file():
        what = "a folder" if path.is_dir() else "no such file"
        raise unusable(path, what, "give the path of a recording (.h5)")
    if not is_hdf5(path):
        what = "an empty file" if path.stat().st_size == 0 else "something else than an HDF5 file"
        raise unusable(path, what, "give the path of a recording (.h5)")
    try:
        with open_to_read(path) as file:
            yield _entry(path, file)
    except InputError:
        raise
    except HDF5_ERRORS as error:
        what = "a truncated file" if "truncated" in str(error) else "a damaged file"
        raise unusable(
            path, f"{what} ({error})", "take the file from a backup or copy it again, or repeat the run"
        ) from error


def _entry(path: Path, file: Group) -> Group:
    """The entry of a file that is a recording, of a layout that is known, and whole."""
    if "entry/definition" not in file or file.text("entry/definition") != layout.DEFINITION:
        raise unusable(path, "an HDF5 file by another program", "give the path of a recording (.h5)")
    entry = file.at("entry")
    version = str(entry.attribute_of("definition", "version"))
    if version.split(".", maxsplit=1)[0] != layout.VERSION.split(".", maxsplit=1)[0]:
        raise unusable(
            path,
            f"a recording of layout {version}, while this program reads {layout.VERSION}",
            "install a newer Kinopix",
        )
    _refuse_cut_off(path, entry)
    return entry


def _recording(path: Path, entry: Group) -> Recording:
    plan = plan_of(path, entry)
    values = entry.array(layout.VALUES)
    refuse_narrow_values(path, values.shape, plan)
    return Recording(
        plan=plan,
        values=values,
        frame_valid=_frame_valid(path, entry, values),
        picture_time_s=entry.number(layout.PICTURE_TIME_S),
        edge_time_s=_edge_time_s(entry, len(values)),
        photon_counts=bool(entry.number(layout.PHOTON_COUNTS)),
        dead_time_s=entry.number(layout.DEAD_TIME_S),
        dark_rate_hz=entry.number(layout.DARK_RATE_HZ),
        truth=_truth(entry),
        timing=timing_of(entry),
        path=path,
    )


def _refuse_cut_off(path: Path, entry: Group) -> None:
    """Refuse what has lost its end since its writer died, before HDF5 looks for it, at length and in vain."""
    written = int(entry.number(layout.FILE_BYTES)) if layout.FILE_BYTES in entry else 0
    size = path.stat().st_size
    if size < written:
        raise OSError(f"truncated: the recording goes on to byte {written}, the file ends at {size}")


def plan_of(path: Path, entry: Group) -> Plan:
    """The plan of an open recording.

    Raises:
        InputError: this program does not know it.
    """
    try:
        return Plan.from_json(entry.text(layout.PLAN))
    except (ValidationError, ValueError) as error:
        raise unusable(path, f"a plan that this program does not know ({error})", "install a newer Kinopix") from error
    except InputError as error:
        saw = f"a plan that this program does not know: {error.saw}"
        raise unusable(path, saw, "install the distribution that offers its scheme") from error


def refuse_narrow_values(path: Path, shape: tuple[int, ...], plan: Plan) -> None:
    """Refuse values that are not a row of patterns for each frame.

    Raises:
        InputError: names both shapes.
    """
    patterns = plan.patterns_per_frame
    if len(shape) != 2 or shape[1] != patterns:
        raise unusable(path, f"values of shape {shape}, not (frames, {patterns})", "repeat the run")


def refuse_other_mask(path: Path, flags: int, frames: int) -> None:
    """Refuse a mask that is not one flag a frame.

    Raises:
        InputError: names both numbers.
    """
    if flags != frames:
        raise unusable(path, f"a mask of {flags} frames for {frames} frames of values", "repeat the run")


def _frame_valid(path: Path, entry: Group, values: Floats) -> Mask:
    """The mask of the audit; where there was none, the frames in which every pattern has a value."""
    measured = layout.measured_frames(values)
    if layout.FRAME_VALID not in entry:  # layout 1.0
        return measured
    valid = entry.array(layout.FRAME_VALID).astype(bool)
    if not len(valid):  # not finished yet, or never
        return measured
    refuse_other_mask(path, len(valid), len(measured))
    return valid


def _edge_time_s(entry: Group, frames: int) -> Floats | None:
    edges = entry.array(layout.EDGE_TIME_S)[:frames]
    return edges if np.isfinite(edges).any() else None


def timing_of(entry: Group) -> TimingReport | None:
    """The audit; None where the run was cut off before it, or where another program left it out."""
    if layout.TIMING_REPORT not in entry:
        return None
    try:
        return TimingReport.model_validate_json(entry.text(layout.TIMING_REPORT))
    except ValidationError:
        return None


def _truth(entry: Group) -> Truth | None:
    if layout.TRUTH_IMAGE not in entry:
        return None
    displacement_px = entry.array(layout.TRUTH_DISPLACEMENT_PX)
    if not len(displacement_px):  # not finished yet, or never
        return None
    return Truth(displacement_px=displacement_px, image=entry.array(layout.TRUTH_IMAGE))
