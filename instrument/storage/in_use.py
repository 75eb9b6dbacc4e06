"""Whether a recording is being written now, by this program or another one."""

from pathlib import Path

from instrument.storage import layout
from instrument.storage.hdf5 import Group
from instrument.storage.hdf5_file import InUse, open_to_read
from instrument.storage.part import is_locked, parts_of
from instrument.storage.soundness import HDF5_ERRORS
from protocols import InputError


def refuse_while_written(path: Path, *, but: Path | None = None) -> None:
    """Make sure that nobody records into ``path``, analyses it, or changes it; to be asked before any work begins.

    It covers writers on this computer, and on others where the file system passes on locks. On Windows it finds none that has
    opened the recording itself: there the system does not let a file be replaced that is open. A file whose writer was killed
    is not refused, nor is one that others read.

    Args:
        path: the recording, there or not.
        but: a part that is the caller's own.

    Raises:
        InputError: somebody does; for a run or an analysis it names the process and since when.
    """
    target = path.resolve()
    refuse_while_made(path, but=but)
    if not target.is_file() or not is_locked(target):
        return
    try:
        with open_to_read(target) as file:
            if "entry" not in file:
                return
            entry = file.at("entry")
            if has_ended(entry):
                return  # a reader holds the lock
            process = entry.attribute_of(layout.PROGRAM_NAME, "process_id")
            since = entry.text(layout.START_TIME)
    except InUse as error:
        raise in_use(path) from error
    except HDF5_ERRORS:
        return  # whoever reads it says what is wrong with it
    raise _refused(path, "recorded", process, since)


def refuse_while_made(path: Path, *, but: Path | None = None) -> None:
    """Make sure that no run is about to take the place of ``path``, and no analysis.

    Args:
        path: the recording, there or not.
        but: a part that is the caller's own.

    Raises:
        InputError: names the process and since when.
    """
    for part in parts_of(path.resolve()):
        if part.alive and part.path != but:
            raise _refused(path, part.purpose, part.process, part.since)


def has_ended(entry: Group) -> bool:
    """Whether the run of an open recording has come to an end, whatever it was; one of layout 1.0 always has."""
    if layout.INTERRUPTED not in entry:
        return True
    return bool(int(entry.attribute("complete"))) or bool(entry.text(layout.INTERRUPTED))


def in_use(path: Path) -> InputError:
    """Make the error for a file that another program has open for writing."""
    return InputError(
        saw=f"{path}, which is in use by another program that has it open for writing",
        expected="a recording that nobody writes",
        remedy="close that program, or work on a copy of the file",
    )


def _refused(path: Path, purpose: str, process: object, since: str) -> InputError:
    return InputError(
        saw=f"{path}, which is being {purpose} by process {process} since {since}",
        expected="a recording that nobody writes",
        remedy="wait for its end, or work on a copy of the file",
    )
