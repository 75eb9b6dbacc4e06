"""What becomes of a recording that the disk did not take: all that is still held goes to a spill file."""

from dataclasses import dataclass, replace
from pathlib import Path
from threading import Thread
from typing import Final

from instrument.storage.failure import StorageFailed
from instrument.storage.spill import Record, places_for, write_spill
from instrument.storage.writer import RecordingWriter

_SPILL_S: Final = 1.0
"""So long a place may take to be spilled to, before the next one is tried."""


@dataclass(frozen=True)
class Rescue:
    """What became of a recording that the disk did not take."""

    error: StorageFailed
    """Why."""

    kept_until: int
    """Patterns that were on the disk, in the recording."""

    spill: Path | None
    """File with what came after them; None where there was nothing more, or where it could be written nowhere."""

    journal: Path | None = None
    """File with everything that had been written, from which the recording can be made anew; None where nothing had been."""

    doubt: str = ""
    """Why that file may not survive a power cut; empty where it does."""

    lost: str = ""
    """Why what came after could be written nowhere; empty where it was, or had not to be."""


def spilled(rescue: Rescue, writer: RecordingWriter, records: list[Record]) -> Rescue:
    """Spill what a recording could not take to the first place that takes it for good, or else that takes it at all."""
    refused: list[str] = []
    doubtful: list[tuple[Path, str]] = []
    for place in places_for(writer.path):
        written, why = _try(place, writer, records)
        if not why:
            for other, _ in doubtful:
                other.unlink(missing_ok=True)
            return replace(rescue, spill=place)
        if written:
            doubtful.append((place, why))
        refused.append(f"{place.parent}: {why}")
    for other, _ in doubtful[1:]:
        other.unlink(missing_ok=True)
    if doubtful:
        place, why = doubtful[0]
        return replace(rescue, spill=place, doubt=why)
    return replace(rescue, lost="; ".join(refused))


def _try(place: Path, writer: RecordingWriter, records: list[Record]) -> tuple[bool, str]:
    """Spill to a place within ``_SPILL_S``; give whether the file is whole, and why it may not last."""
    written: list[bool] = []
    said: list[str] = []

    def spill() -> None:
        try:
            write_spill(place, writer.run, records)
            written.append(True)
            writer.sync_other(place)
        except OSError as error:
            said.append(str(error))
        else:
            said.append("")

    thread = Thread(target=spill, name="kinopix-spill", daemon=True)
    thread.start()
    thread.join(_SPILL_S)
    return bool(written), said[0] if said else f"no answer for {_SPILL_S:g} s"
