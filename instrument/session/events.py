"""What a run tells while it goes on: frozen values that can be stored and sent.

``kind`` tells them apart. ``event.model_dump_json()`` and ``event_from_json`` are inverse, but for the arrays of a block, which
only listeners in the same process get.
"""

import math
from dataclasses import replace
from typing import Annotated, Any, Final, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field, NonNegativeInt, PlainSerializer, PlainValidator, TypeAdapter, WithJsonSchema
from pydantic.json_schema import SkipJsonSchema

from instrument.acquisition import AlignedBlock, Phase
from instrument.recording import Verdict
from protocols import Floats, Frozen


def _from_lists(value: Any) -> Floats:
    array = np.array(value, dtype=np.float64)  # None becomes NaN
    array.flags.writeable = False
    return array


def _as_lists(array: Floats) -> Any:
    def plain(value: list[Any] | float) -> list[Any] | float | None:
        if isinstance(value, list):
            return [plain(item) for item in value]
        return value if math.isfinite(value) else None

    return plain(array.tolist())


Array: TypeAlias = Annotated[
    NDArray[np.float64],
    PlainValidator(_from_lists),
    PlainSerializer(_as_lists),
    WithJsonSchema({"type": "array"}),
]
"""A read-only copy of an array; as JSON nested lists, with ``null`` for NaN."""


class _Event(Frozen):
    model_config = ConfigDict(arbitrary_types_allowed=True)


class PhaseEvent(_Event):
    """The run turned to something else."""

    kind: Literal["phase"] = "phase"
    phase: Phase
    """What begins now."""


class UploadEvent(_Event):
    """Patterns were stored in the modulator."""

    kind: Literal["upload"] = "upload"
    stored: NonNegativeInt
    """Unique patterns stored so far."""
    total: NonNegativeInt
    """Unique patterns in all."""


class BlockEvent(_Event):
    """Patterns were counted, and are on their way into the file."""

    kind: Literal["block"] = "block"
    first_pattern: NonNegativeInt
    """Index of the first pattern, from 0."""
    patterns: NonNegativeInt
    """How many."""
    block: SkipJsonSchema[AlignedBlock | None] = Field(default=None, exclude=True, repr=False)
    """Values, mask and edge times, read-only; None for an event that came from another process."""

    @classmethod
    def of(cls, block: AlignedBlock) -> Self:
        """Copy a block, so that its buffers may be used again and no listener can change what another one sees."""
        edges = block.edge_time_s
        copy = replace(
            block,
            values=_read_only(block.values),
            valid=_read_only(block.valid),
            edge_time_s=None if edges is None else _read_only(edges),
            gaps=_read_only(block.gaps),
            doubles=_read_only(block.doubles),
            irregular=_read_only(block.irregular),
        )
        return cls(first_pattern=block.first_pattern, patterns=len(block.values), block=copy)


def _read_only(array: Any) -> Any:
    copy = array.copy()
    copy.flags.writeable = False
    return copy


class TrackingEvent(_Event):
    """The live analysis followed the object through more frames."""

    kind: Literal["tracking"] = "tracking"
    frame: NonNegativeInt
    """Frames followed so far: the newest is number ``frame - 1``."""
    displacement_px: Array
    """``(n, 2)`` x, y of the newest n frames, relative to frame 0; n may be 0."""
    sigma_px: Array = Field(default_factory=lambda: _from_lists([]))
    """``(n, 2)`` standard uncertainty of these displacements, NaN where none is known; no rows where nobody states any."""
    frames_dropped: NonNegativeInt = 0
    """Frames that the live analysis lost because it was late. The recording has them."""
    images: NonNegativeInt = 0
    """Images made so far."""
    images_skipped: NonNegativeInt = 0
    """Images that were due and not made."""
    final: bool = False
    """Whether nothing comes after it."""


class ImageEvent(_Event):
    """The live analysis made an image."""

    kind: Literal["image"] = "image"
    frame: NonNegativeInt
    """Frames that it is made of, and those before them."""
    image: Array
    """``(m, m)`` row = y (down), column = x, in values for one lit pixel."""
    final: bool = False
    """Whether this is the polished image of the whole run."""


class FindingEvent(_Event):
    """The audit found something that a person should know."""

    kind: Literal["finding"] = "finding"
    message: str
    """A sentence."""


class FinishedEvent(_Event):
    """The run is over: the devices are safe, or named in ``error``, and the file is closed."""

    kind: Literal["finished"] = "finished"
    outcome: Literal["done", "failed", "aborted"]
    """``failed``: an error ended it; ``aborted``: somebody did, or a rule of the plan."""
    path: str | None = None
    """The recording, whole or partial; None where nothing is kept."""
    verdict: Verdict | None = None
    """Of the timing audit; None where the run broke before it."""
    error: str | None = None
    """What ended the run early."""
    notes: tuple[str, ...] = ()
    """What is kept, what the listeners missed."""


Event: TypeAlias = Annotated[
    PhaseEvent | UploadEvent | BlockEvent | TrackingEvent | ImageEvent | FindingEvent | FinishedEvent,
    Field(discriminator="kind"),
]
"""Any of them."""

_EVENT: Final[TypeAdapter[Event]] = TypeAdapter(Event)


def event_from_json(text: str | bytes) -> Event:
    """Give the event that ``model_dump_json`` wrote.

    Raises:
        pydantic.ValidationError: it is none.
    """
    return _EVENT.validate_json(text)
