"""Whether a recording may be written to a place: asked before anything moves."""

import shutil
from pathlib import Path

from instrument.storage.hdf5_file import is_hdf5
from instrument.storage.in_use import refuse_while_written
from instrument.storage.part import is_locked
from instrument.storage.room import longest_file
from protocols import InputError

_BYTES_A_PATTERN = 4 * 8
"""Value, edge time, and both again as they arrived."""
_BYTES_BESIDE = 1 << 20
"""Room for everything else."""


def refuse_existing(path: Path, *, overwrite: bool = False) -> None:
    """Make sure that a recording may be written to ``path``; to be asked before anything moves.

    Raises:
        InputError: somebody records into ``path``, the file exists and ``overwrite`` is not set, it is something else than an
            HDF5 file, another program has it open, or its folder is missing.
    """
    target = path.resolve()
    if not target.parent.is_dir():
        raise InputError(
            saw=f"no folder {path.parent}",
            expected="an existing folder for the recording",
            remedy="make the folder, or name another one",
        )
    refuse_while_written(path)
    if not target.exists():
        return
    if not overwrite:
        raise InputError(
            saw=f"{path}, which exists",
            expected="the name of a new file",
            remedy="name another file, or give --overwrite to lose the old one",
        )
    if not target.is_file() or not is_hdf5(target):
        raise InputError(
            saw=f"{path}, which is no HDF5 file",
            expected="a recording to overwrite",
            remedy="name another file; if this one is really to go, remove it by hand",
        )
    if is_locked(target):
        raise cannot_be_written(path, "another program has it open")


def needed_on_disk(patterns: int) -> int:
    """Give the bytes of a recording, and of its copy when an analysis is stored."""
    return 2 * patterns * _BYTES_A_PATTERN + _BYTES_BESIDE


def refuse_full_disk(path: Path, patterns: int) -> None:
    """Make sure that there is room for a recording: HDF5 gives up without grace on a full disk.

    Raises:
        InputError: there is less than the recording, and its copy when an analysis is stored, take.
    """
    needed = needed_on_disk(patterns)
    free = min(shutil.disk_usage(path.resolve().parent).free, longest_file())
    if free < needed:
        raise InputError(
            saw=f"{free / 1e6:.1f} MB free for {path}",
            expected=f"{needed / 1e6:.1f} MB for {patterns} patterns",
            remedy="make room on the disk, or name another folder",
        )


def cannot_be_written(path: Path, why: object) -> InputError:
    """Make the error for a place that the system refuses."""
    return InputError(
        saw=f"{path}, which cannot be written: {why}",
        expected="a place for the recording",
        remedy="close the program that holds the file, or name another file",
    )
