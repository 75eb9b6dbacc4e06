"""A thin typed face of h5py, which has no types: only what a recording needs."""

import errno
import math
import os
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Literal, Self, TypeAlias, cast

import h5py  # pyright: ignore[reportMissingTypeStubs]
import numpy as np
from numpy.typing import NDArray

from instrument.storage.soundness import (
    WrongItem,
    described,
    end_of_chunks,
    reading,
    refuse_cut_off,
    refuse_elsewhere,
    refuse_foreign,
    refuse_hollow,
)

_h5py: Any = h5py

Value: TypeAlias = str | bool | float | list[str] | NDArray[Any] | np.generic
"""What a dataset or an attribute can hold. Truth values are stored as uint8, which every program reads."""

_MOST_TEXT_BYTES: Final = 1 << 24
"""Longest text that is read: the bench and the timing audit have some ten thousand bytes."""

_FORMAT = ("v110", "v110")
"""File format of HDF5 1.10 (2016), the oldest that can be read while it is written (SWMR)."""


_LEFT_OPEN: Final = list[Any]()
"""Objects of files that failed, which are never closed."""


class InUse(OSError):
    """Another program has the file open for writing, and lets nobody read."""


class Group:
    """A group of an HDF5 file. What is read is looked at first: files come from anywhere."""

    def __init__(self, handle: Any) -> None:
        """Wrap an ``h5py.Group``."""
        self._handle = handle

    def group(self, name: str, nx_class: str, **attributes: Value) -> "Group":
        """Create a group below this one."""
        group = Group(self._handle.create_group(name))
        group.set_attributes(NX_class=nx_class, **attributes)
        return group

    def add(self, name: str, value: Value, **attributes: Value) -> None:
        """Create a dataset that holds ``value`` and never changes."""
        _set_attributes(self._handle.create_dataset(name, data=_stored(value)), attributes)

    def add_all(self, values: Mapping[str, Value]) -> None:
        """``add`` each of several values that have no unit."""
        for name, value in values.items():
            self.add(name, value)

    def rows(self, name: str) -> "Growing":
        """Give a dataset that can grow, to go on with it."""
        return Growing(self._item(name))

    def growing(self, name: str, row: tuple[int, ...], rows_per_chunk: int, **attributes: Value) -> None:
        """Create an empty float64 dataset of shape ``(0, *row)`` that can grow; what is not written is NaN."""
        dataset = self._handle.create_dataset(
            name,
            shape=(0, *row),
            maxshape=(None, *row),
            chunks=(rows_per_chunk, *row),
            dtype=np.float64,
            fillvalue=np.nan,
        )
        _set_attributes(dataset, attributes)

    def set_attributes(self, **attributes: Value) -> None:
        """Set attributes of this group."""
        _set_attributes(self._handle, attributes)

    def add_text_to_come(self, name: str, room_bytes: int) -> None:
        """Create an empty text that can be overwritten while others read, as long as it has no more bytes than that."""
        self._handle.create_dataset(name, data=b"", dtype=_h5py.string_dtype("utf-8", room_bytes))

    def add_numbers_to_come(self, name: str, rows_per_chunk: int, kind: type[np.generic], **attributes: Value) -> None:
        """Create an empty dataset of whole numbers that can grow; what is not written is 0."""
        dataset = self._handle.create_dataset(name, shape=(0,), maxshape=(None,), chunks=(rows_per_chunk,), dtype=kind)
        _set_attributes(dataset, attributes)

    def set_value(self, name: str, value: Value) -> None:
        """Overwrite a dataset with a value of the same shape and type, or a text that fits.

        Raises:
            ValueError: a text that is too long.
        """
        dataset = self._handle[name]
        content: Any = _stored(value)
        if isinstance(value, str):
            content, room = value.encode(), int(dataset.dtype.itemsize)
            if len(content) > room:
                raise ValueError(f"{len(content)} bytes for {name}, which has room for {room}")
        with _writing(dataset):
            dataset[...] = content
            dataset.flush()

    def set_attribute(self, name: str, value: Value) -> None:
        """Overwrite an attribute of this group with a value of the same shape and type."""
        with _writing(self._handle):
            self._handle.attrs.modify(name, _stored(value))
            self._handle.file.flush()

    def __contains__(self, name: str) -> bool:
        """Whether a dataset or group of that path is there.

        Raises:
            WrongItem: a soft or external link is on the way, which is never followed.
        """
        return self._find(name) is not None

    def at(self, name: str) -> "Group":
        """The group at a path below this one.

        Raises:
            WrongItem: it is missing, something else, or behind a soft or external link. So for all that is read.
        """
        found = self._item(name)
        if not isinstance(found, _h5py.Group):
            raise WrongItem(f"{found.name} is no group")
        return Group(found)

    def text(self, name: str) -> str:
        """A dataset of one string."""
        dataset = self._dataset(name)
        kind = _h5py.check_string_dtype(dataset.dtype)
        if kind is None or dataset.shape != ():
            raise WrongItem(f"{dataset.name} is no text, but {described(dataset)}")
        if (kind.length or 0) > _MOST_TEXT_BYTES:
            raise WrongItem(f"{dataset.name} is a text of {kind.length} bytes, of at most {_MOST_TEXT_BYTES}")
        with reading(dataset.name):
            return cast("str", dataset.asstr()[()])

    def number(self, name: str) -> float:
        """A dataset of one number."""
        dataset = self._numbers(name)
        if dataset.shape != ():
            raise WrongItem(f"{dataset.name} is not one number, but {described(dataset)}")
        with reading(dataset.name):
            return float(dataset[()])

    def array(self, name: str) -> NDArray[Any]:
        """A whole dataset of numbers.

        Raises:
            OSError: the file ends before the data do. HDF5 itself gives zeros then, if the file's writer was killed.
            WrongItem: as ``at``; it holds no numbers, or has a shape for more numbers than the file holds.
        """
        dataset = self._sound(name)
        with reading(dataset.name):
            return cast("NDArray[Any]", dataset[...])

    def head(self, name: str, rows: int) -> NDArray[Any]:
        """The first rows of a dataset of numbers.

        Raises:
            OSError, WrongItem: as ``array``.
        """
        dataset = self._sound(name)
        with reading(dataset.name):
            return cast("NDArray[Any]", dataset[:rows])

    def shape(self, name: str) -> tuple[int, ...]:
        """The shape of a dataset of numbers, without reading it.

        Raises:
            OSError, WrongItem: as ``array``.
        """
        return cast("tuple[int, ...]", self._sound(name).shape)

    def shape_of(self, name: str) -> tuple[int, ...]:
        """The shape of a dataset of a file that is being written."""
        return cast("tuple[int, ...]", self._numbers(name).shape)

    def _sound(self, name: str) -> Any:
        """A dataset of numbers that the file holds to its end, and that is no larger than what it holds."""
        dataset = self._numbers(name)
        with reading(dataset.name):
            size, end = Path(dataset.file.filename).stat().st_size, end_of_chunks(dataset)
            if end > size:
                raise OSError(f"truncated: {name} goes on to byte {end}, the file ends at {size}")
            refuse_hollow(dataset, size)
        return dataset

    def attribute(self, key: str) -> Any:
        """An attribute of this group, or None where it is missing."""
        return _attribute(self._handle, key)

    def attribute_of(self, name: str, key: str) -> Any:
        """An attribute of a dataset or group, or None where it is missing."""
        return _attribute(self._item(name), key)

    def refuse_foreign(self) -> None:
        """Make sure that everything in the file is held by the file itself, as ``soundness.refuse_foreign`` does."""
        refuse_foreign(self._handle["/"])

    def _find(self, name: str) -> Any:
        """What is at a path, by hard links alone; None where it is missing."""
        found = self._handle["/"] if isinstance(self._handle, _h5py.File) else self._handle
        for part in name.split("/"):
            where = f"{found.name.rstrip('/')}/{part}"
            if not isinstance(found, _h5py.Group):
                raise WrongItem(f"{found.name} is no group")
            with reading(where):
                if not found.id.links.exists(part.encode()):
                    return None
                kind = found.id.links.get_info(part.encode()).type
                if kind != _h5py.h5l.TYPE_HARD:
                    raise WrongItem(f"{where} is a link to somewhere else, which is not followed")
                found = found[part]
        return found

    def _item(self, name: str) -> Any:
        found = self._find(name)
        if found is None:
            raise WrongItem(f"{self._handle.name.rstrip('/')}/{name} is missing")
        return found

    def _dataset(self, name: str) -> Any:
        found = self._item(name)
        if not isinstance(found, _h5py.Dataset):
            raise WrongItem(f"{found.name} is no dataset")
        with reading(found.name):
            refuse_elsewhere(found)
            _ = found.dtype, found.shape
        return found

    def _numbers(self, name: str) -> Any:
        dataset = self._dataset(name)
        if dataset.dtype.kind not in "fiu":
            raise WrongItem(f"{dataset.name} holds no numbers, but {described(dataset)}")
        return dataset

    def copy_to(self, target: "Group", without: str = "") -> None:
        """Copy attributes and everything below this group into ``target``, but for the child ``without``."""
        for name, value in self._handle.attrs.items():
            target._handle.attrs[name] = value  # noqa: SLF001 - a group too
        for name in self._handle:
            if name != without:
                self._handle.copy(name, target._handle)  # noqa: SLF001


class Growing:
    """A dataset that rows are appended to."""

    def __init__(self, handle: Any) -> None:
        """Wrap an ``h5py.Dataset``."""
        self._handle = handle

    def write(self, first: int, rows: NDArray[Any]) -> None:
        """Write ``rows`` from row ``first`` on, growing as needed, and hand them to the operating system."""
        with _writing(self._handle):
            self._handle.resize(max(len(self._handle), first + len(rows)), axis=0)
            self._handle[first : first + len(rows)] = rows
            self._handle.flush()

    def replace(self, rows: NDArray[Any]) -> None:
        """Make ``rows`` all that it holds."""
        self._handle.resize(len(rows), axis=0)
        self._handle[...] = rows

    def read(self) -> NDArray[Any]:
        """Give all rows."""
        return cast("NDArray[Any]", self._handle[...])

    @property
    def width(self) -> int:
        """Numbers a row."""
        return math.prod(cast("tuple[int, ...]", self._handle.shape[1:]))

    def __len__(self) -> int:
        """Rows now."""
        return int(self._handle.shape[0])


class File(Group):
    """An open HDF5 file; a context manager that closes it."""

    def __init__(self, path: Path, mode: Literal["r", "w", "r+", "swmr"], *, locks: bool = True) -> None:
        """Open or create the file.

        Args:
            path: where it is.
            mode: ``r`` reads, ``w`` creates and empties, ``r+`` goes on with it, ``swmr`` reads a file that a writer has open, or
                had open when it died.
            locks: whether HDF5 locks the file; not where the caller holds the lock already.
        """
        keys = {"libver": _FORMAT} if mode in {"w", "r+"} else {"swmr": mode == "swmr"}
        # Network drives often have no locks: that must not keep anybody from recording.
        locking = "best-effort" if locks else False
        super().__init__(_h5py.File(path, "r" if mode == "swmr" else mode, locking=locking, **keys))
        self._descriptor = int(self._handle.id.get_vfd_handle())  # asked now: later HDF5 may be in a call that hangs

    def let_others_read(self) -> None:
        """From now on others may read while this file is written, and it stays readable at whatever moment the writer dies.

        No group, dataset or attribute can be added after this; datasets can grow.
        """
        self._handle.swmr_mode = True

    @property
    def is_open(self) -> bool:
        """Whether it is open."""
        return bool(self._handle)

    def detach(self) -> None:
        """Part from a file that can no longer be written, and leave it as it is.

        HDF5 crashes when it closes a file after a write that failed, and looks without end for metadata that somebody has cut
        off. So its descriptor is turned to the null device, which takes everything: nothing that HDF5 does afterwards, also at
        the end of the process, reaches the file or can fail. No lock of HDF5 is needed, so a call that hangs is no obstacle.
        """
        if self._descriptor < 0:
            return
        _detach(self._descriptor)

    def leave_open(self) -> None:
        """Never close this file: HDF5 failed with it, and may crash."""
        _LEFT_OPEN.append(self._handle)

    def close(self) -> None:
        """Close the file; allowed twice."""
        self._handle.close()
        self._descriptor = -1

    def __enter__(self) -> Self:
        """Give the open file."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self.close()


def hdf5_has_failed() -> bool:
    """Whether HDF5 failed with a file of this process, or does not come back from it: it may crash when the process ends."""
    return bool(_LEFT_OPEN)


def note_that_hdf5_hangs(call: object) -> None:
    """Take note that HDF5 does not come back from a call on another thread."""
    _LEFT_OPEN.append(call)


@contextmanager
def _writing(handle: Any) -> Generator[None]:
    """Detach the file at once where a write fails: closing any object of it, which Python does by itself, may crash HDF5."""
    try:
        yield
    except (OSError, RuntimeError):
        _LEFT_OPEN.append(handle)
        _detach(int(handle.file.id.get_vfd_handle()))
        raise


def _detach(descriptor: int) -> None:
    nothing = os.open(os.devnull, os.O_RDWR)
    try:
        os.dup2(nothing, descriptor)
    finally:
        os.close(nothing)


def is_hdf5(path: Path) -> bool:
    """Whether the file begins as an HDF5 file does."""
    return bool(_h5py.is_hdf5(path))


def _set_attributes(handle: Any, attributes: Mapping[str, Value]) -> None:
    for key, value in attributes.items():
        handle.attrs[key] = _stored(value)


def _attribute(handle: Any, key: str) -> Any:
    with reading(f"{handle.name}/@{key}"):
        return handle.attrs.get(key)


def _stored(value: Value) -> Any:
    if isinstance(value, bool) or (isinstance(value, np.ndarray) and value.dtype == np.bool_):
        return np.asarray(value, dtype=np.uint8)
    return value


@contextmanager
def open_to_read(path: Path) -> Generator[File]:
    """Open a file whole, or as its writer left it when it died, or as it is while it is being written.

    Raises:
        InUse: another program has it open for writing, and lets nobody read.
        OSError: it is damaged.
    """
    try:
        file = File(path, "r")
    except OSError as error:
        if "already open for" not in str(error) and error.errno not in {errno.EAGAIN, errno.EACCES}:
            raise
        refuse_cut_off(path)
        file = _open_while_written(path)
    with file:
        yield file


def _open_while_written(path: Path) -> File:
    try:
        return File(path, "swmr")
    except OSError as error:
        if error.errno in {errno.EAGAIN, errno.EACCES}:
            raise InUse(str(error)) from error
        if "not already open for SWMR" in str(error):
            raise OSError("a program died while it changed the file, and did not close it") from error
        raise
