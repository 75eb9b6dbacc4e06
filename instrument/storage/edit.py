"""A recording changed as a whole or not at all."""

import os
import sys
from collections.abc import Callable, Generator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from shutil import copyfileobj
from typing import Final

import numpy as np

from instrument.storage import layout
from instrument.storage.hdf5 import Group
from instrument.storage.hdf5_file import File, open_to_read, opened_bytes
from instrument.storage.in_use import refuse_while_written
from instrument.storage.part import Part, remove_remains
from instrument.storage.room import Room
from instrument.storage.soundness import HDF5_ERRORS
from protocols import InputError

_METADATA_BYTES: Final = 1 << 18
"""What HDF5 needs beside the numbers, by far."""


def refuse_unchangeable(path: Path, into: Path | None = None, *, content: bool = True) -> None:
    """Make sure that an analysis of ``path`` can be stored when it is done; to be asked before the work begins.

    What programs that died have left beside the recording is removed.

    Args:
        path: the recording.
        into: where a copy with the analysis goes; None for the recording itself.
        content: whether what the recording holds will be copied.

    Raises:
        InputError: the recording is being written, or may not be written; it has another name (a hard link), which would keep
            the old content; it holds what is kept elsewhere; or ``into`` is taken or has no folder.
    """
    source = path.resolve()
    remove_remains(path if into is None else into)
    refuse_while_written(path)
    if into is None:
        _refuse_read_only(path, source)
    else:
        _refuse_taken(into)
    if content and source.is_file():
        _refuse_foreign(path, source)


@contextmanager
def rewritten(path: Path, into: Path | None = None, *, more_bytes: int, instead: bytes = b"") -> Generator[Group]:
    """Give ``/entry`` of a copy of a recording, without its analysis, and put the copy in place at the end.

    It serves three needs: what is added is there whole or not at all, a file whose writer died is sound again, and the
    space of an earlier analysis is given back. Whoever has ``path`` open keeps the file as it was. A link to the recording
    stays a link; permissions, owner and extended attributes go along. If anything fails, nothing is changed.

    Args:
        path: the recording.
        into: where the copy goes; None for the place of ``path``.
        more_bytes: numbers and texts that will be added. Room for them and the copy is taken before HDF5 writes, which
            cannot live with a write that fails.
        instead: a recording that takes part in place of what ``path`` holds.

    Raises:
        InputError: the recording was changed by somebody else meanwhile, or the copy cannot be made: there is no room.
    """
    source = path.resolve()
    before = source.stat()
    target = source if into is None else into.resolve()
    part = _part(target)
    try:
        with _with_room(path, part, before.st_size + more_bytes + _METADATA_BYTES) as new:
            yield _copied(path, lambda: opened_bytes(instead) if instead else open_to_read(source), new)
        _put_sound(part, path, before, into)
    finally:
        _end(part)


def _part(target: Path) -> Part:
    try:
        return Part(target, "analysed")
    except OSError as error:
        raise _unstorable(f"{target.parent}, where no file can be made ({error})") from error


def _put_sound(part: Part, path: Path, before: os.stat_result, into: Path | None) -> None:
    """Put a whole copy in its place, unless the recording was changed since ``before``."""
    source = path.resolve()
    _give_what_goes_along(source, before, part.path)
    with part.path.open("rb+") as written:
        os.fsync(written.fileno())
    now = source.stat()
    if (now.st_ino, now.st_size, now.st_mtime_ns) != (before.st_ino, before.st_size, before.st_mtime_ns):
        raise InputError(
            saw=f"{path}, which was changed while its analysis was stored",
            expected="a recording that nobody writes",
            remedy="analyse it again",
        )
    _put_in_place(part, into)


def _end(part: Part) -> None:
    """Leave a part that has its place, and remove one that has not."""
    if part.path == part.target:
        part.release()
    else:
        part.discard()


@contextmanager
def _with_room(path: Path, part: Part, needed: int) -> Generator[File]:
    """A new HDF5 file that has its room on the disk. Where anything fails, HDF5 writes no more of it."""
    try:
        Room(part.path, part.fileno()).take(needed)
        new = File(part.path, "w", locks=False)
        room = Room(part.path, part.fileno())  # HDF5 has emptied the file, and its room is gone
        room.take(needed)
    except OSError as error:
        raise _no_room(path, needed, error) from error
    try:
        yield new
        new.close()
        room.give_back()
    except BaseException:
        new.detach()
        with suppress(OSError, RuntimeError):
            new.close()
        raise


def _no_room(path: Path, needed: int, error: OSError) -> InputError:
    return InputError(
        saw=f"no room for a copy of {path} with what is added, {needed / 1e6:.1f} MB: {error}",
        expected="room on the disk, until the copy has taken the place of the recording",
        remedy="make room, or name a new file on another disk (--results for an analysis, --out for a recovery)",
    )


def _copied(path: Path, opened: Callable[[], AbstractContextManager[File]], new: File) -> Group:
    try:
        with opened() as old:
            old.refuse_foreign()  # a journal may have been made by anybody
            old.copy_to(new, without="entry")
            entry = new.group("entry", "NXentry")
            old.at("entry").copy_to(entry, without="analysis")
            if layout.FILE_BYTES in entry:
                entry.set_value(layout.FILE_BYTES, np.int64(0))  # as in every file that is closed well
    except HDF5_ERRORS as error:
        raise InputError(
            saw=f"{path}, which cannot be copied with its analysis: {error}",
            expected="a sound recording, and room on the disk for its copy",
            remedy="make room; if there is enough, take the recording from a backup",
        ) from error
    return entry


def _put_in_place(part: Part, into: Path | None) -> None:
    try:
        part.put_in_place(replace=into is None)
    except FileExistsError as error:
        raise _taken(part.target) from error


def _give_what_goes_along(source: Path, before: os.stat_result, copy: Path) -> None:
    """Give the copy the owner, permissions and extended attributes of its source."""
    if sys.platform == "win32":
        return
    made = copy.stat()
    if (made.st_uid, made.st_gid) != (before.st_uid, before.st_gid):
        try:
            os.chown(copy, before.st_uid, before.st_gid)
        except OSError as error:
            raise _unstorable(f"{source}, whose owner you are not: a file by you would take its place") from error
    copy.chmod(before.st_mode & 0o7777)
    if sys.platform == "linux":
        try:
            for name in os.listxattr(source):
                os.setxattr(copy, name, os.getxattr(source, name))
        except OSError as error:
            raise _unstorable(f"{source}, whose extended attributes cannot be copied ({error})") from error


def _refuse_read_only(path: Path, source: Path) -> None:
    if not source.is_file():
        return  # whoever reads it says so
    status, folder = source.stat(), source.parent
    # Root may write everything: whoever took the permission away meant it all the same.
    if not status.st_mode & 0o222 or not os.access(source, os.W_OK):
        raise _unstorable(f"{path}, which is read-only")
    if not folder.stat().st_mode & 0o222 or not os.access(folder, os.W_OK | os.X_OK):
        raise _unstorable(f"{path} in a read-only folder")
    if status.st_nlink > 1:
        raise _unstorable(f"{path}, a file of {status.st_nlink} names (hard links), of which one would be left behind")


def _refuse_taken(into: Path) -> None:
    if not into.resolve().parent.is_dir():
        raise InputError(
            saw=f"no folder {into.parent}",
            expected="an existing folder for the results",
            remedy="make the folder, or name another one",
        )
    if os.path.lexists(into):
        raise _taken(into)
    if not os.access(into.resolve().parent, os.W_OK | os.X_OK):
        raise _unstorable(f"a read-only folder for {into}")


def _refuse_foreign(path: Path, source: Path) -> None:
    try:
        with open_to_read(source) as file:
            file.refuse_foreign()
    except ValueError as error:
        raise InputError(
            saw=f"{path}, which holds something that is kept elsewhere: {error}",
            expected="a recording by `kinopix run`, which holds all of itself",
            remedy="remove it from the file; what it points to is neither read nor copied",
        ) from error
    except HDF5_ERRORS:
        return  # whoever reads it says what is wrong with it


def _taken(into: Path) -> InputError:
    return InputError(
        saw=f"{into}, which exists", expected="the name of a new file for the results", remedy="name another file"
    )


def _unstorable(saw: str) -> InputError:
    return InputError(
        saw=saw,
        expected="a recording that the analysis can be written into",
        remedy="give --results FILE (from Python: into) for a copy with the analysis, and leave the recording as it is",
    )


def put_back(changed: Path, path: Path, before: os.stat_result, into: Path | None = None) -> None:
    """Put a copy of a recording that was changed elsewhere in place of it, or at a new name; all or nothing, as ``rewritten``.

    Args:
        changed: the copy, complete.
        path: the recording it was copied from.
        before: state of that file when it was copied.
        into: where the copy goes; None for the place of ``path``.

    Raises:
        InputError: the recording was changed by somebody else meanwhile, or the copy cannot be made: there is no room.
    """
    source = path.resolve()
    target = source if into is None else into.resolve()
    part = _part(target)
    try:
        try:
            with changed.open("rb") as from_there, part.path.open("wb") as here:
                copyfileobj(from_there, here, 1 << 20)
        except OSError as error:
            raise _no_room(path, changed.stat().st_size, error) from error
        _put_sound(part, path, before, into)
    finally:
        _end(part)
