"""How a recording is told in documents: what its arrays are, where they lie, and how to find it again."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final
from urllib.parse import quote, unquote, urlsplit
from urllib.request import url2pathname
from uuid import uuid4

from bluesky.protocols import Reading, StreamAsset
from event_model.documents import DataKey, StreamDatum, StreamRange, StreamResource

from instrument.plan import Plan
from instrument.recording import Recording
from instrument.storage import open_recording
from protocols import InputError

MIMETYPE: Final = "application/x-hdf5"
"""Of a recording, as catalogues know it."""

_VALUES: Final = "/entry/data/values"
_VALID: Final = "/entry/timing/frame_valid"


def described(name: str, plan: Plan) -> dict[str, DataKey]:
    """Describe the arrays of which a frame has an entry each: its values in play order, and whether it is valid."""
    patterns = plan.patterns_per_frame
    return {
        f"{name}-values": {
            "source": f"kinopix://{name}/values",
            "dtype": "array",
            "dtype_numpy": "<f8",
            "shape": [1, patterns],
            "external": "STREAM:",
        },
        f"{name}-frame_valid": {
            "source": f"kinopix://{name}/frame_valid",
            "dtype": "array",
            "dtype_numpy": "|u1",
            "shape": [1],
            "external": "STREAM:",
        },
    }


def assets(name: str, plan: Plan, path: Path, frames: int) -> Iterator[StreamAsset]:
    """Give the documents of a recording that is whole: a resource for each array, and all frames of it.

    Args:
        name: of the detector.
        plan: of the run.
        path: the file.
        frames: number of frames in it; nothing is told of a recording without one.
    """
    if not frames:
        return
    datasets = {f"{name}-values": (_VALUES, [1, plan.patterns_per_frame]), f"{name}-frame_valid": (_VALID, [1])}
    for key, (dataset, one) in datasets.items():
        resource = str(uuid4())
        chunk = [min(frames, 1024), *one[1:]]
        file = StreamResource(
            uid=resource,
            data_key=key,
            mimetype=MIMETYPE,
            uri=f"file://localhost{quote(path.absolute().as_posix())}",
            parameters={"dataset": dataset, "chunk_shape": chunk, "swmr": False},
        )
        yield "stream_resource", file
        rows = StreamDatum(
            uid=f"{resource}/0",
            stream_resource=resource,
            descriptor="",  # the RunEngine fills in this, and the numbers
            seq_nums=StreamRange(start=0, stop=0),
            indices=StreamRange(start=0, stop=frames),
        )
        yield "stream_datum", rows


def configuration(name: str, plan: Plan) -> tuple[dict[str, Reading[Any]], dict[str, DataKey]]:
    """Give the figures of a plan that tell runs apart, as readings and as what they are."""
    figures: dict[str, tuple[Any, str | None]] = {
        "scheme": (plan.scheme.name, None),
        "frames": (plan.frames, None),
        "image_size": (plan.image_size, "px"),
        "pattern_rate": (float(plan.pattern_rate_hz), "Hz"),
    }
    if plan.motion is not None:
        figures["start"] = (plan.motion.start_mm, "mm")
        figures["velocity"] = (plan.motion.velocity_mm_s, "mm/s")
        figures["acceleration"] = (plan.motion.acceleration_mm_s2, "mm/s^2")
    readings: dict[str, Reading[Any]] = {}
    keys: dict[str, DataKey] = {}
    for figure, (value, unit) in figures.items():
        key = f"{name}-{figure}"
        readings[key] = {"value": value, "timestamp": 0.0}
        keys[key] = {
            "source": f"kinopix://{name}/plan/{figure}",
            "dtype": "string" if isinstance(value, str) else "integer" if isinstance(value, int) else "number",
            "shape": [],
        }
        if unit is not None:
            keys[key]["units"] = unit
    return readings, keys


def recording_of(resource: StreamResource) -> Recording:
    """Open the recording that a ``stream_resource`` document names.

    Raises:
        InputError: it names no file, or as ``open_recording``.
    """
    parts = urlsplit(resource["uri"])
    if resource["mimetype"] != MIMETYPE or parts.scheme != "file":
        raise InputError(
            saw=f"a resource of type {resource['mimetype']} at {resource['uri']}",
            expected=f"{MIMETYPE} in a file",
            remedy="take the stream_resource of a KinopixDetector",
        )
    return open_recording(Path(url2pathname(unquote(parts.path))))
