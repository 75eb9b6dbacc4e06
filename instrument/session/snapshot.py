"""Where a run stands, as one value: for whoever comes late, and for whoever asks now and then."""

from typing import Final, Literal, TypeAlias

from pydantic import NonNegativeInt

from instrument.acquisition import Phase
from instrument.session.events import BlockEvent, Event, FindingEvent, FinishedEvent, PhaseEvent, UploadEvent
from protocols import Frozen

RunState: TypeAlias = Literal["preparing", "running", "finishing", "done", "failed", "aborted"]
"""``preparing``: patterns are uploaded, the stage goes to its start. ``running``: the counter is armed, things move.
``finishing``: devices come to rest for good and the file is closed. The others are ends."""

_STATE: Final[dict[Phase, RunState]] = {
    "uploading": "preparing",
    "positioning": "preparing",
    "arming": "running",
    "running up": "running",
    "counting": "running",
    "coming to rest": "running",
    "making safe": "finishing",
    "storing": "finishing",
}

_LONGEST: Final = 1000  # findings kept


class ListenerFailure(Frozen):
    """A listener that raised, and was told nothing more."""

    listener: str
    """Its name."""
    error: str
    """What it raised."""


class Snapshot(Frozen):
    """A run at one moment."""

    state: RunState = "preparing"
    """Coarsely."""
    phase: Phase | None = None
    """Finely; the last one after the end, None before the first."""
    patterns_done: NonNegativeInt = 0
    """Patterns counted, and in the file or on their way into it."""
    patterns_total: NonNegativeInt
    """Patterns of the plan."""
    upload_done: NonNegativeInt = 0
    """Unique patterns stored in the modulator."""
    upload_total: NonNegativeInt = 0
    """Unique patterns in all; 0 before the upload."""
    path: str
    """Where the recording is written to."""
    findings: tuple[str, ...] = ()
    """What the audit found so far."""
    finished: FinishedEvent | None = None
    """How it ended; None before."""
    error: str | None = None
    """What ended the run early."""
    listener_failures: tuple[ListenerFailure, ...] = ()
    """Listeners that raised."""
    blocks_dropped: NonNegativeInt = 0
    """Blocks that listeners missed because they were late, all together."""

    def after(self, event: Event) -> "Snapshot":
        """Where the run stands when ``event`` has come."""
        match event:
            case PhaseEvent():
                return self.model_copy(update={"phase": event.phase, "state": _STATE[event.phase]})
            case UploadEvent():
                return self.model_copy(update={"upload_done": event.stored, "upload_total": event.total})
            case BlockEvent():
                return self.model_copy(update={"patterns_done": event.first_pattern + event.patterns})
            case FindingEvent():
                return self.model_copy(update={"findings": (*self.findings, event.message)[:_LONGEST]})
            case FinishedEvent():
                return self.model_copy(update={"state": event.outcome, "finished": event, "error": event.error})
            case _:
                return self
