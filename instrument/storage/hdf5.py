"""A thin typed face of h5py, which has no types: only what a recording needs."""

import errno
import math
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self, TypeAlias, cast

import h5py  # pyright: ignore[reportMissingTypeStubs]
import numpy as np
from numpy.typing import NDArray

_h5py: Any = h5py

Value: TypeAlias = str | bool | float | list[str] | NDArray[Any] | np.generic
"""What a dataset or an attribute can hold. Truth values are stored as uint8, which every program reads."""

HDF5_ERRORS = (OSError, RuntimeError, KeyError)
"""What h5py raises for a file that is damaged."""

_FORMAT = ("v110", "v110")
"""File format of HDF5 1.10 (2016), the oldest that can be read while it is written (SWMR)."""


class Group:
    """A group of an HDF5 file."""

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

    def growing(self, name: str, row: tuple[int, ...], rows_per_chunk: int, **attributes: Value) -> "Growing":
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
        return Growing(dataset)

    def set_attributes(self, **attributes: Value) -> None:
        """Set attributes of this group."""
        _set_attributes(self._handle, attributes)

    def add_text_to_come(self, name: str, room_bytes: int) -> None:
        """Create an empty text that can be overwritten while others read, as long as it has no more bytes than that."""
        self._handle.create_dataset(name, data=b"", dtype=_h5py.string_dtype("utf-8", room_bytes))

    def add_flags_to_come(self, name: str, rows_per_chunk: int) -> "Growing":
        """Create an empty dataset of flags that can grow; what is not written is 0."""
        return Growing(
            self._handle.create_dataset(name, shape=(0,), maxshape=(None,), chunks=(rows_per_chunk,), dtype=np.uint8)
        )

    def set_value(self, name: str, value: Value) -> None:
        """Overwrite a dataset with a value of the same shape and type, or a text that fits.

        Raises:
            ValueError: a text that is too long.
        """
        dataset = self._handle[name]
        if isinstance(value, str):
            text, room = value.encode(), int(dataset.dtype.itemsize)
            if len(text) > room:
                raise ValueError(f"{len(text)} bytes for {name}, which has room for {room}")
            dataset[...] = text
        else:
            dataset[...] = _stored(value)
        dataset.flush()

    def set_attribute(self, name: str, value: Value) -> None:
        """Overwrite an attribute of this group with a value of the same shape and type."""
        self._handle.attrs.modify(name, _stored(value))
        self._handle.file.flush()

    def __contains__(self, name: str) -> bool:
        """Whether a dataset or group of that path is there."""
        return name in self._handle

    def at(self, name: str) -> "Group":
        """The group at a path below this one."""
        return Group(self._handle[name])

    def text(self, name: str) -> str:
        """A dataset of one string."""
        return cast("str", self._handle[name].asstr()[()])

    def number(self, name: str) -> float:
        """A dataset of one number."""
        return float(self._handle[name][()])

    def array(self, name: str) -> NDArray[Any]:
        """A whole dataset.

        Raises:
            OSError: the file ends before the data do. HDF5 itself gives zeros then, if the file's writer was killed.
        """
        return cast("NDArray[Any]", self._sound(name)[...])

    def head(self, name: str, rows: int) -> NDArray[Any]:
        """The first rows of a dataset.

        Raises:
            OSError: as ``array``.
        """
        return cast("NDArray[Any]", self._sound(name)[:rows])

    def shape(self, name: str) -> tuple[int, ...]:
        """The shape of a dataset, without reading it.

        Raises:
            OSError: as ``array``.
        """
        return cast("tuple[int, ...]", self._sound(name).shape)

    def _sound(self, name: str) -> Any:
        """A dataset that the file holds to its end."""
        dataset = self._handle[name]
        size, end = Path(dataset.file.filename).stat().st_size, _end_of_chunks(dataset)
        if end > size:
            raise OSError(f"truncated: {name} goes on to byte {end}, the file ends at {size}")
        return dataset

    def attribute(self, key: str) -> Any:
        """An attribute of this group, or None where it is missing."""
        return self._handle.attrs.get(key)

    def attribute_of(self, name: str, key: str) -> Any:
        """An attribute of a dataset or group, or None where it is missing."""
        return self._handle[name].attrs.get(key)

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
        self._handle.resize(max(len(self._handle), first + len(rows)), axis=0)
        self._handle[first : first + len(rows)] = rows
        self._handle.flush()

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

    def __init__(self, path: Path, mode: Literal["r", "w", "swmr"]) -> None:
        """Open or create the file.

        Args:
            path: where it is.
            mode: ``r`` reads, ``w`` creates and empties, ``swmr`` reads a file that a writer has open, or had open when it died.
        """
        keys = {"libver": _FORMAT} if mode == "w" else {"swmr": mode == "swmr"}
        # Network drives often have no locks: that must not keep anybody from recording.
        super().__init__(_h5py.File(path, "w" if mode == "w" else "r", locking="best-effort", **keys))

    def let_others_read(self) -> None:
        """From now on others may read while this file is written, and it stays readable at whatever moment the writer dies.

        No group, dataset or attribute can be added after this; datasets can grow.
        """
        self._handle.swmr_mode = True

    @property
    def is_open(self) -> bool:
        """Whether it is open."""
        return bool(self._handle)

    def close(self) -> None:
        """Close the file; allowed twice."""
        self._handle.close()

    def __enter__(self) -> Self:
        """Give the open file."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self.close()


def is_hdf5(path: Path) -> bool:
    """Whether the file begins as an HDF5 file does."""
    return bool(_h5py.is_hdf5(path))


def _set_attributes(handle: Any, attributes: Mapping[str, Value]) -> None:
    for key, value in attributes.items():
        handle.attrs[key] = _stored(value)


def _end_of_chunks(dataset: Any) -> int:
    """First byte after the last chunk of a dataset; 0 for one that is not stored in chunks."""
    ends = [0]
    if dataset.chunks is not None:

        def note(chunk: Any) -> None:
            ends.append(chunk.byte_offset + chunk.size)

        dataset.id.chunk_iter(note)
    return max(ends)


def _stored(value: Value) -> Any:
    if isinstance(value, bool) or (isinstance(value, np.ndarray) and value.dtype == np.bool_):
        return np.asarray(value, dtype=np.uint8)
    return value


def _refuse_cut_off(path: Path) -> None:
    """Refuse a file that is shorter than its superblock says, as HDF5 does itself for files that are not ``swmr``.

    Versions 2 and 3 hold the address of the end in bytes 28 to 35 (HDF5 file format specification, section II.A).
    """
    with path.open("rb") as file:
        start = file.read(36)
    size, end = path.stat().st_size, int.from_bytes(start[28:36], "little")
    if len(start) < 36 or (start[8] >= 2 and size < end):
        raise OSError(f"truncated: it goes on to byte {end}, the file ends at {size}")


@contextmanager
def open_to_read(path: Path) -> Generator[File]:
    """Open a file whole, or as its writer left it when it died, or as it is while it is being written."""
    try:
        file = File(path, "r")
    except OSError as error:
        if "already open for" not in str(error) and error.errno not in {errno.EAGAIN, errno.EACCES}:
            raise
        _refuse_cut_off(path)
        file = File(path, "swmr")
    with file:
        yield file
