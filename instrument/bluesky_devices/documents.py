"""How a recording is told in documents: what its arrays are, where they lie, and how to find it again."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, Self
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

_CHUNK: Final = 1024
"""Frames that a catalogue hands out at a time."""


def values_key(key: str, plan: Plan) -> dict[str, DataKey]:
    """Describe the values of a frame, in play order."""
    return {
        key: {
            "source": f"kinopix://{key}",
            "dtype": "array",
            "dtype_numpy": "<f8",
            "shape": [1, plan.patterns_per_frame],
            "external": "STREAM:",
        }
    }


def valid_key(key: str) -> dict[str, DataKey]:
    """Describe whether a frame is valid."""
    return {
        key: {
            "source": f"kinopix://{key}",
            "dtype": "array",
            "dtype_numpy": "|u1",
            "shape": [1],
            "external": "STREAM:",
        }
    }


class Rows:
    """An array of a recording that has a row for each frame, told of as it grows: a resource first, then its frames."""

    def __init__(self, key: str, dataset: str, row: tuple[int, ...], path: Path) -> None:
        """Nothing has been told.

        Args:
            key: of the data.
            dataset: where the array is in the file.
            row: shape of what a frame has.
            path: the file.
        """
        self._key = key
        self._dataset = dataset
        self._row = row
        self._path = path
        self._resource = str(uuid4())
        self._told = self._documents = 0

    @classmethod
    def of_values(cls, key: str, path: Path, plan: Plan) -> Self:
        """Tell of the values."""
        return cls(key, "/entry/data/values", (plan.patterns_per_frame,), path)

    @classmethod
    def of_valid(cls, key: str, path: Path) -> Self:
        """Tell of which frames are valid."""
        return cls(key, "/entry/timing/frame_valid", (), path)

    def up_to(self, frames: int) -> Iterator[StreamAsset]:
        """Give the documents of what is new; nothing where nothing is.

        Args:
            frames: number of frames that whoever opens the file finds in it.
        """
        if frames <= self._told:
            return
        if not self._documents:
            file = StreamResource(
                uid=self._resource,
                data_key=self._key,
                mimetype=MIMETYPE,
                uri=f"file://localhost{quote(self._path.absolute().as_posix())}",
                parameters={"dataset": self._dataset, "chunk_shape": [_CHUNK, *self._row], "swmr": True},
            )
            yield "stream_resource", file
        rows = StreamDatum(
            uid=f"{self._resource}/{self._documents}",
            stream_resource=self._resource,
            descriptor="",  # the RunEngine fills in this, and the numbers
            seq_nums=StreamRange(start=0, stop=0),
            indices=StreamRange(start=self._told, stop=frames),
        )
        self._told, self._documents = frames, self._documents + 1
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
