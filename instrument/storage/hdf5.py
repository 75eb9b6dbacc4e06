"""A thin typed face of h5py, which has no types: only what a recording needs."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, TypeAlias, cast

import h5py  # pyright: ignore[reportMissingTypeStubs]
import numpy as np
from numpy.typing import NDArray

from instrument.storage.hdf5_failure import writing
from instrument.storage.soundness import (
    WrongItem,
    described,
    end_of_chunks,
    reading,
    refuse_elsewhere,
    refuse_foreign,
    refuse_hollow,
)

_h5py: Any = h5py

Value: TypeAlias = str | bool | float | list[str] | NDArray[Any] | np.generic
"""What a dataset or an attribute can hold. Truth values are stored as uint8, which every program reads."""

_MOST_TEXT_BYTES: Final = 1 << 24
"""Longest text that is read: the bench and the timing audit have some ten thousand bytes."""


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
        with writing(dataset):
            dataset[...] = content
            dataset.flush()

    def set_attribute(self, name: str, value: Value) -> None:
        """Overwrite an attribute of this group with a value of the same shape and type."""
        with writing(self._handle):
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

    def part(self, name: str, first: int, end: int) -> NDArray[Any]:
        """The rows ``first`` to ``end`` of a dataset of numbers, and no others are read.

        Raises:
            OSError, WrongItem: as ``array``.
        """
        dataset = self._sound(name)
        with reading(dataset.name):
            return cast("NDArray[Any]", dataset[first:end])

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
            size, end = _bytes_of(dataset.file), end_of_chunks(dataset)
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
        with writing(self._handle):
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


def _bytes_of(file: Any) -> int:
    """Length of an open file on the disk, whatever HDF5 believes of one that was cut off."""
    if file.driver == "fileobj":
        return int(file.id.get_filesize())
    return Path(file.filename).stat().st_size


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
