"""Whether a recording is being written now, by this program or another one."""

import sys
from contextlib import suppress
from pathlib import Path
from typing import IO

from instrument.storage import layout
from instrument.storage.hdf5 import Group, open_to_read
from protocols import InputError

if sys.platform != "win32":
    import fcntl


class WritersMark:
    """Marks a recording as being written until it is released or the program ends, however it ends.

    The mark is a shared ``flock`` of the writer on the recording itself. HDF5 takes a lock of its own when it opens the file, and
    gives it up when others may read. Readers (``swmr``) are not kept out, and nothing is left behind by a program that is killed.
    """

    def __init__(self, path: Path) -> None:
        """Mark ``path``, which exists; where the file system has no locks, nothing happens."""
        self._file: IO[bytes] = path.open("rb")
        if sys.platform != "win32":
            with suppress(OSError):
                fcntl.flock(self._file, fcntl.LOCK_SH | fcntl.LOCK_NB)

    def release(self) -> None:
        """Take the mark away; allowed twice."""
        self._file.close()


def refuse_while_written(path: Path) -> None:
    """Make sure that nobody records into ``path``.

    It covers writers on this computer, and on others where the file system passes on locks. On Windows it finds none: there the
    system itself does not let a file be replaced that is open. A file whose writer was killed is not refused.

    Raises:
        InputError: it is being recorded; names the process and since when.
    """
    if not is_marked(path):
        return
    with open_to_read(path) as file:
        entry = file.at("entry")
        if has_ended(entry):
            return  # a reader holds the lock
        process = entry.attribute_of(layout.PROGRAM_NAME, "process_id")
        since = entry.text(layout.START_TIME)
    raise InputError(
        saw=f"{path}, which is being recorded by process {process} since {since}",
        expected="a recording that nobody writes",
        remedy="wait for the end of the run, or work on a copy of the file",
    )


def has_ended(entry: Group) -> bool:
    """Whether the run of an open recording has come to an end, whatever it was."""
    return bool(entry.attribute("complete")) or (layout.INTERRUPTED in entry and bool(entry.text(layout.INTERRUPTED)))


def is_marked(path: Path) -> bool:
    """Whether somebody, a writer or a reader, holds a lock on a file; False where the system has no such locks."""
    if sys.platform == "win32":
        return False
    with path.open("rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:
            return False
        return False
