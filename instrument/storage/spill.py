"""Counts that a recording could not take, in a plain file that Python's own reading and writing suffices for.

The file is a JSON line, and then records. A record is a JSON line (``what``, ``first``, ``count``, ``crc32``) and ``count``
little-endian float64 numbers, whose first has the index ``first`` in the dataset of that name; a text has ``text`` in its line
and no numbers. The CRC-32 is that of the numbers, or of the text. What follows a record that is cut off or changed is not read.
The reference is docs/reference/recording.md.
"""

import json
import os
import secrets
import sys
import tempfile
import zlib
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Final

import numpy as np

from protocols import Floats, InputError

FORMAT: Final = "kinopix-spill"
"""Value of ``format`` in the first line."""

EMPTY_RECORDING: Final = "empty recording"
"""What the first record of a journal holds: the bytes of the recording before its first block, padded to whole float64."""

_LONGEST_LINE: Final = 1 << 20
FLAGS: Final = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
"""How a spill file is made: no link is followed, and nothing that is there is written over."""


@dataclass(frozen=True, eq=False)
class Record:
    """One piece of what a recording lacks."""

    what: str
    """Name of the dataset, below ``/entry``."""

    first: int
    """Index of the first number in it, flattened."""

    numbers: Floats
    """``(n,)``; empty for a text."""

    text: str = ""
    """The text, where the dataset holds one."""


@dataclass(frozen=True, eq=False)
class Spill:
    """A spill file that was read."""

    path: Path
    """The file."""

    run: str
    """Which recording it belongs to, as ``run_of`` names it."""

    records: Sequence[Record]
    """Its records, in the order in which they were written."""

    lost_bytes: int
    """Bytes at the end that are no whole record."""

    @property
    def empty_recording(self) -> bytes:
        """Of a journal, the recording before its first block; nothing of other spill files."""
        first = self.records[0] if self.records else None
        return first.numbers.astype("<f8").tobytes() if first is not None and first.what == EMPTY_RECORDING else b""


def places_for(recording: Path) -> list[Path]:
    """Give the files that counts may be spilled to, the best first: beside the recording, and in the temporary folder."""
    places = [beside(recording)]
    with suppress(OSError):  # there may be no folder that can be written
        places.append(Path(tempfile.gettempdir()) / places[0].name)
    return places


def beside(recording: Path) -> Path:
    """Give a new name for a spill file beside a recording."""
    return recording.with_name(f"{recording.name}.{secrets.token_hex(4)}.spill")


def head_of(run: str) -> bytes:
    """Give the first line of a spill file."""
    return _line({"format": FORMAT, "version": 1, "run": run})


def stored_record(record: Record) -> bytes:
    """Give a record as it is stored."""
    raw = record.numbers.astype("<f8").tobytes()
    head: dict[str, object] = {"what": record.what, "first": record.first, "count": len(record.numbers)}
    if record.text:
        head["text"] = record.text
    return _line({**head, "crc32": zlib.crc32(raw or record.text.encode())}) + raw


def write_spill(path: Path, run: str, records: Iterable[Record]) -> None:
    """Write a spill file and hand it to the system. A file that could not be written whole is removed.

    Raises:
        OSError: it cannot be written.
    """
    file = os.open(path, FLAGS, 0o600)
    try:
        with os.fdopen(file, "wb") as out:
            out.write(head_of(run))
            for record in records:
                out.write(stored_record(record))
    except OSError:
        path.unlink(missing_ok=True)
        raise


def read_spill(path: Path) -> Spill:
    """Read a spill file as far as it is whole.

    Raises:
        InputError: it is none.
    """
    try:
        with path.open("rb") as file:
            head = _parsed(file.readline(_LONGEST_LINE))
            if head.get("format") != FORMAT or head.get("version") != 1:
                raise InputError(
                    saw=f"{path}, which is no spill file of a recording",
                    expected="a file that a run has written beside its recording, *.spill",
                    remedy="name the file that the run named when it ended",
                )
            records: list[Record] = []
            good = file.tell()
            while (record := _record(file)) is not None:
                records.append(record)
                good = file.tell()
            return Spill(path, str(head.get("run")), records, path.stat().st_size - good)
    except OSError as error:
        raise InputError(
            saw=f"{path}, which cannot be read: {error}",
            expected="a spill file",
            remedy="check its name and permissions",
        ) from error


def spills_of(recording: Path, run: str | None) -> list[Spill]:
    """Read the spill files that belong to a recording, beside it and in the temporary folder.

    Args:
        recording: where it is.
        run: which run it is, as ``run_of`` names it; None where the recording cannot be read: then that of the newest journal.
    """
    found = _named_as(recording)
    if run is None:
        journals = [spill for spill in found if spill.empty_recording]
        run = max(journals, key=lambda spill: spill.path.stat().st_mtime_ns).run if journals else ""
    return [spill for spill in found if spill.run == run]


def _named_as(recording: Path) -> list[Spill]:
    found: list[Spill] = []
    for folder in dict.fromkeys((recording.parent, *(place.parent for place in places_for(recording)))):
        with suppress(OSError):
            for path in sorted(folder.iterdir()):
                named = path.name.startswith(f"{recording.name}.") and path.name.endswith(".spill")
                if named and path.is_file() and not path.is_symlink() and _is_ours(path):
                    with suppress(InputError):
                        found.append(read_spill(path))
    return found


def run_of(start_time: str, process: object) -> str:
    """Name a run so that no other has the name: by its process and the millisecond of its start."""
    return f"{start_time} {process}"


def _is_ours(path: Path) -> bool:
    """Whether nobody else can have put it there: the temporary folder is everybody's."""
    return sys.platform == "win32" or path.stat().st_uid in {0, os.getuid()}


def _line(head: dict[str, object]) -> bytes:
    return json.dumps(head).encode() + b"\n"


def _parsed(line: bytes) -> dict[str, Any]:
    with suppress(ValueError, RecursionError):
        head = json.loads(line) if line.endswith(b"\n") else None
        if isinstance(head, dict):
            return {str(key): value for key, value in head.items()}  # pyright: ignore[reportUnknownVariableType, reportUnknownArgumentType]
    return {}


def _record(file: IO[bytes]) -> Record | None:
    """The next record; None where none follows that is whole."""
    head = _parsed(file.readline(_LONGEST_LINE))
    what, first, count, text, crc = (head.get(key) for key in ("what", "first", "count", "text", "crc32"))
    if not (isinstance(what, str) and isinstance(first, int) and isinstance(count, int) and first >= 0 and count >= 0):
        return None
    left = os.fstat(file.fileno()).st_size - file.tell()
    if 8 * count > left:
        return None
    raw = file.read(8 * count)
    words = text if isinstance(text, str) else ""
    if zlib.crc32(raw or words.encode()) != crc:
        return None
    return Record(what, first, np.frombuffer(raw, "<f8").astype(np.float64), words)
