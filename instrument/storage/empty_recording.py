"""A recording before its first block: everything that is known before a run, and a place for everything that comes."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np

from instrument.plan import Plan
from instrument.recording import STAGE_COLUMNS
from instrument.roles import ROLES, RoleName
from instrument.storage import layout
from instrument.storage.checksum import FRAMES_A_BLOCK
from instrument.storage.frames import OpenRecording
from instrument.storage.hdf5 import Group
from instrument.storage.hdf5_file import File
from instrument.storage.provenance import PROGRAM, now, program_version
from instrument.storage.spill import run_of
from protocols import DeviceIdentity

_ROWS_PER_CHUNK = 1024
_RAW_PER_CHUNK = 8192
_FLAGS_PER_CHUNK = 8192  # whoever looks at a recording reads them all: chunks of a thousand cost as much as the rest
_STAGE_ROWS = 64
_REPORT_BYTES: Final = 1 << 16
"""Room for the timing audit, which lists a thousand patterns of each kind at most."""
_REASON_BYTES: Final = 4096
"""Room for why a run ended early."""


def empty_recording(
    place: Path,
    plan: Plan,
    figures: Mapping[str, tuple[float, str]],
    texts: Mapping[str, str],
    devices: Mapping[RoleName, DeviceIdentity],
    *,
    name: str,
    with_truth: bool,
) -> tuple[OpenRecording, str]:
    """Make the file with all that is known now; give it, and the name of the run.

    Args:
        place: an empty file that is there.
        name: what it will be called.
        plan: what was asked for.
        figures: numbers and their units, by the name of their dataset.
        texts: likewise.
        devices: identity of each device.
        with_truth: whether it will be given a truth.

    Raises:
        OSError, RuntimeError: it cannot be written.
    """
    file = File(place, "w")
    try:
        entry = file.group("entry", "NXentry", default="data", complete=False)
        file.set_attributes(NX_class="NXroot", default="entry", file_name=name, creator=PROGRAM)
        entry.add_all(texts)
        run = _add_origin(entry, devices)
        _add_people(entry, plan)
        for what, (figure, unit) in figures.items():
            entry.add(what, figure, units=unit)
        _add_what_grows(entry, plan.patterns_per_frame)
        _add_what_comes_last(entry, plan.image_size if with_truth else None)
        return OpenRecording(file, plan.patterns_per_frame), run
    except BaseException:
        file.detach()
        file.close()
        raise


def fitting_reason(text: str) -> str:
    """``text``, without its end where a recording has no room for it."""
    room_bytes = _REASON_BYTES
    encoded = text.encode()
    return text if len(encoded) <= room_bytes else encoded[: room_bytes - 3].decode(errors="ignore") + "..."


def _add_origin(entry: Group, devices: Mapping[RoleName, DeviceIdentity]) -> str:
    """Add who records when, and give the name of the run."""
    process, start_time = os.getpid(), now()
    entry.add("definition", layout.DEFINITION, version=layout.VERSION)
    entry.add(layout.PROGRAM_NAME, PROGRAM, version=program_version(), process_id=process)
    entry.add(layout.START_TIME, start_time)
    instrument = entry.group("instrument", "NXinstrument")
    groups = {role.name: instrument.group(role.name, role.nx_class) for role in ROLES}
    for name, identity in devices.items():
        groups[name].add_all(identity.model_dump())
    return run_of(start_time, process)


def _add_people(entry: Group, plan: Plan) -> None:
    """Add user, sample and notes where NeXus has them; the plan has them too."""
    if plan.run is None:
        return
    for where, nx_class, text in (
        (layout.USER_NAME, "NXuser", plan.run.user),
        (layout.SAMPLE_NAME, "NXsample", plan.run.sample),
        (layout.NOTES, "NXnote", plan.run.notes),
    ):
        if text:
            group, name = where.split("/")
            entry.group(group, nx_class).add(name, text)
    if plan.run.notes:
        entry.add(layout.NOTES_TYPE, "text/plain")


def _add_what_grows(entry: Group, patterns_per_frame: int) -> None:
    entry.add(layout.PHOTON_COUNTS, value=False)
    entry.growing(layout.RAW_COUNTS, (), _RAW_PER_CHUNK)
    entry.growing(layout.RAW_EDGE_TIME_S, (), _RAW_PER_CHUNK, units="s")
    entry.group("data", "NXdata", signal="values", axes=[".", "."])
    row = (patterns_per_frame,)
    rows = max(1, min(_ROWS_PER_CHUNK, _RAW_PER_CHUNK // patterns_per_frame))
    entry.growing(layout.VALUES, row, rows, long_name="light of each pattern, in play order")
    entry.growing(layout.EDGE_TIME_S, row, rows, units="s")


def _add_what_comes_last(entry: Group, truth_size: int | None) -> None:
    entry.add(layout.FILE_BYTES, np.zeros((), np.int64))
    entry.add_text_to_come(layout.END_TIME, len(now()))
    entry.add_text_to_come(layout.INTERRUPTED, _REASON_BYTES)
    what = "time from the start of the modulator (s), reported (mm), commanded (mm), 1 where predicted"
    entry.growing(layout.STAGE_POSITIONS, (STAGE_COLUMNS,), _STAGE_ROWS, long_name=what)
    entry.group("timing", "NXcollection")
    entry.add_numbers_to_come(layout.FRAME_VALID, _FLAGS_PER_CHUNK, np.uint8)
    entry.add_text_to_come(layout.TIMING_REPORT, _REPORT_BYTES)
    entry.group("checksum", "NXcollection", algorithm="CRC-32", frames_per_block=FRAMES_A_BLOCK)
    for name in (layout.CHECKSUM_VALUES, layout.CHECKSUM_EDGES):
        entry.add_numbers_to_come(name, _ROWS_PER_CHUNK, np.uint32)
    if truth_size is not None:
        entry.group("truth", "NXcollection")
        entry.growing(layout.TRUTH_DISPLACEMENT_PX, (2,), _ROWS_PER_CHUNK, units="px")
        image = np.full((truth_size, truth_size), np.nan)
        entry.add(layout.TRUTH_IMAGE, image, long_name="transmission of the object at frame 0")
        background = "transmission of what stands still; without rows where there is nothing"
        entry.growing(layout.TRUTH_BACKGROUND, (truth_size,), truth_size, long_name=background)
