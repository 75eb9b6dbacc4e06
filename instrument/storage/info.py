"""What a recording is, told without reading its values: for a look at a file of any size, at any moment of its life."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias

import numpy as np
from pydantic import NonNegativeInt, PositiveFloat, SerializeAsAny

from instrument.config import PluginMissing
from instrument.plan import Plan
from instrument.recording import TimingReport
from instrument.roles import ROLES
from instrument.storage import layout
from instrument.storage.hdf5 import Group
from instrument.storage.part import is_locked
from instrument.storage.reader import opened_recording, plan_of, refuse_narrow_values, refuse_other_mask, timing_of
from protocols import DeviceIdentity, Frozen, InputError
from protocols.plain_file import path_of

RecordingState: TypeAlias = Literal["complete", "interrupted", "being recorded", "cut off"]
"""``interrupted``: the run ended early and its file was closed. ``cut off``: its program ended without closing the file."""

_LOOKED_AT: Final = 64  # frames whose edge times tell whether the counter gives any


class AnalysisInfo(Frozen):
    """The analysis that a recording holds."""

    date: str
    """When it was made, ISO 8601 in UTC."""

    program: str
    """Who made it."""

    version: str
    """Version of that program."""

    table: Mapping[str, Any]
    """Its figures by name, as ``kinopix analyse --json`` prints them."""

    settings: Mapping[str, Any]
    """How it was done."""


class RecordingInfo(Frozen):
    """One recording, without its values."""

    path: Path
    """The file."""

    file_bytes: NonNegativeInt
    """Length of the file, in bytes."""

    title: str
    """One line for people."""

    user: str
    """Who recorded; empty where nobody said, as the next two."""

    sample: str
    """What was looked at."""

    notes: str
    """Whatever else is worth knowing."""

    program: str
    """Who wrote it."""

    version: str
    """Version of that program."""

    layout: str
    """Version of the file's layout."""

    state: RecordingState
    """Whether the run came to its end, or goes on now."""

    interrupted: str
    """Why the run ended early; empty where it did not, or where nobody could write it down."""

    process_id: int | None
    """The process that records now; None where none does."""

    start_time: str
    """ISO 8601, UTC."""

    end_time: str
    """The same; empty where the run goes on or was cut off."""

    plan: SerializeAsAny[Plan] | None
    """What was asked for; None where its scheme is not installed here."""

    missing_scheme: str
    """Name of the scheme that is not installed here; empty where it is. Without it the values cannot be read as light."""

    picture_time_s: PositiveFloat
    """Time from one pattern to the next, as read back from the modulator, in seconds."""

    frames: NonNegativeInt
    """Frames recorded; the last one may be a part."""

    frames_masked: NonNegativeInt | None
    """Of those, frames that analysis leaves out; None where no audit has been stored."""

    photon_counts: bool
    """Whether values are photon counts."""

    edge_times: bool
    """Whether it holds hardware times of the sync edges."""

    truth: bool
    """Whether it holds what really was there, as simulated runs do."""

    timing: TimingReport | None
    """The timing audit; None where there is none."""

    devices: Mapping[str, DeviceIdentity]
    """Identity of each device by role, where the bench told it."""

    analysis: AnalysisInfo | None
    """The analysis; None where there is none."""


def recording_info(path: str | Path) -> RecordingInfo:
    """Tell what a recording is. Reads shapes, attributes, texts and the mask, and no values; a run that goes on is not disturbed.

    Raises:
        InputError: as ``open_recording``.
    """
    path = path_of(path)
    marked = path.is_file() and bool(is_locked(path))  # asked first: who has the file open holds a lock too
    with opened_recording(path) as entry:
        plan, missing = _plan(path, entry)
        shape = entry.shape(layout.VALUES)
        if plan is not None:
            refuse_narrow_values(path, shape, plan)
        state = _state(entry, marked=marked)
        writer = entry.attribute_of(layout.PROGRAM_NAME, "process_id") if state == "being recorded" else None
        return RecordingInfo(
            path=path,
            file_bytes=path.stat().st_size,
            title=_text(entry, "title"),
            user=_text(entry, layout.USER_NAME),
            sample=_text(entry, layout.SAMPLE_NAME),
            notes=_text(entry, layout.NOTES),
            program=_text(entry, layout.PROGRAM_NAME),
            version=str(entry.attribute_of(layout.PROGRAM_NAME, "version")),
            layout=str(entry.attribute_of("definition", "version")),
            state=state,
            interrupted=_text(entry, layout.INTERRUPTED),
            process_id=None if writer is None else int(writer),
            start_time=_text(entry, layout.START_TIME),
            end_time=_text(entry, layout.END_TIME),
            plan=plan,
            missing_scheme=missing,
            picture_time_s=entry.number(layout.PICTURE_TIME_S),
            frames=shape[0],
            frames_masked=_masked(path, entry, shape[0]),
            photon_counts=bool(entry.number(layout.PHOTON_COUNTS)),
            edge_times=bool(np.isfinite(entry.head(layout.EDGE_TIME_S, _LOOKED_AT)).any()),
            truth=layout.TRUTH_IMAGE in entry and entry.shape(layout.TRUTH_DISPLACEMENT_PX)[0] > 0,
            timing=timing_of(entry),
            devices=_devices(entry),
            analysis=_analysis(entry),
        )


def _plan(path: Path, entry: Group) -> tuple[Plan | None, str]:
    """The plan, or the name of the scheme that has to be installed before anybody can know it."""
    try:
        return plan_of(path, entry), ""
    except InputError as error:
        if not isinstance(error.__cause__, PluginMissing):
            raise
        scheme: Any = json.loads(entry.text(layout.PLAN))["scheme"]  # known to be there: its plug-in was looked for
        return None, scheme if isinstance(scheme, str) else str(scheme["name"])


def _text(entry: Group, name: str) -> str:
    """A text that may be missing, with the groups above it."""
    return entry.text(name) if name in entry else ""


def _state(entry: Group, *, marked: bool) -> RecordingState:
    if bool(int(entry.attribute("complete"))):
        return "complete"
    if layout.INTERRUPTED in entry and bool(entry.text(layout.INTERRUPTED)):
        return "interrupted"
    return "being recorded" if marked else "cut off"


def _masked(path: Path, entry: Group, frames: int) -> int | None:
    if layout.FRAME_VALID not in entry:  # layout 1.0
        return None
    valid = entry.array(layout.FRAME_VALID)
    if not len(valid):  # not finished yet, or never
        return None
    refuse_other_mask(path, valid.shape, frames)
    return int(len(valid) - np.count_nonzero(valid))


def _devices(entry: Group) -> dict[str, DeviceIdentity]:
    devices: dict[str, DeviceIdentity] = {}
    for role in ROLES:
        name = f"instrument/{role.name}"
        if f"{name}/name" in entry:
            group = entry.at(name)
            texts = {key: _text(group, key) for key in DeviceIdentity.model_fields if key != "simulated"}
            devices[role.name] = DeviceIdentity(**texts, simulated=bool(group.number("simulated")))
    return devices


def _analysis(entry: Group) -> AnalysisInfo | None:
    if "analysis" not in entry:
        return None
    analysis = entry.at("analysis")
    return AnalysisInfo(
        date=_text(analysis, "date"),
        program=_text(analysis, "program"),
        version=_text(analysis, "version"),
        table=json.loads(_text(analysis, "table") or "{}"),
        settings=json.loads(_text(analysis, "settings") or "{}"),
    )
