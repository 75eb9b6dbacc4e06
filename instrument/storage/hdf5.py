"""A thin typed face of h5py, which has no types: only what a recording needs."""

import errno
import math
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Literal, Self, TypeAlias, cast

import h5py  # pyright: ignore[reportMissingTypeStubs]
import numpy as np
from numpy.typing import NDArray

_h5py: Any = h5py

Value: TypeAlias = str | bool | float | list[str] | NDArray[Any] | np.generic
"""What a dataset or an attribute can hold. Truth values are stored as uint8, which every program reads."""

HDF5_ERRORS = (OSError, RuntimeError, LookupError, ValueError, TypeError, ArithmeticError, AttributeError, MemoryError)
"""What h5py raises for a file that is damaged."""

_MOST_TEXT_BYTES: Final = 1 << 24
"""Longest text that is read: the bench and the timing audit have some ten thousand bytes."""

_MOST_PACKED: Final = 200
"""How much smaller than its numbers a compressed dataset may be. Counts shrink to a tenth."""

_FORMAT = ("v110", "v110")
"""File format of HDF5 1.10 (2016), the oldest that can be read while it is written (SWMR)."""


class InUse(OSError):
    """Another program has the file open for writing, and lets nobody read."""


class WrongItem(ValueError):
    """Something in the file is not what a recording has there. The message begins with its path inside the file."""


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
            raise WrongItem(f"{dataset.name} is no text, but {_described(dataset)}")
        if (kind.length or 0) > _MOST_TEXT_BYTES:
            raise WrongItem(f"{dataset.name} is a text of {kind.length} bytes, of at most {_MOST_TEXT_BYTES}")
        with _reading(dataset.name):
            return cast("str", dataset.asstr()[()])

    def number(self, name: str) -> float:
        """A dataset of one number."""
        dataset = self._numbers(name)
        if dataset.shape != ():
            raise WrongItem(f"{dataset.name} is not one number, but {_described(dataset)}")
        with _reading(dataset.name):
            return float(dataset[()])

    def array(self, name: str) -> NDArray[Any]:
        """A whole dataset of numbers.

        Raises:
            OSError: the file ends before the data do. HDF5 itself gives zeros then, if the file's writer was killed.
            WrongItem: as ``at``; it holds no numbers, or has a shape for more numbers than the file holds.
        """
        dataset = self._numbers(name)
        with _reading(dataset.name):
            size, end = Path(dataset.file.filename).stat().st_size, _end_of_chunks(dataset)
            if end > size:
                raise OSError(f"truncated: {name} goes on to byte {end}, the file ends at {size}")
            _refuse_hollow(dataset, size)
            return cast("NDArray[Any]", dataset[...])

    def attribute(self, key: str) -> Any:
        """An attribute of this group, or None where it is missing."""
        return _attribute(self._handle, key)

    def attribute_of(self, name: str, key: str) -> Any:
        """An attribute of a dataset or group, or None where it is missing."""
        return _attribute(self._item(name), key)

    def refuse_foreign(self) -> None:
        """Make sure that everything in the file is held by the file itself, so that it can be copied.

        Raises:
            WrongItem: names the first soft or external link, virtual dataset, dataset in other files, or object reference.
        """
        seen: set[tuple[int, int]] = set()
        ahead: list[tuple[str, Any]] = [("", self._handle["/"])]
        with _reading("/"):
            _refuse_attribute_references("", self._handle["/"])
        while ahead:
            path, group = ahead.pop()
            with _reading(path or "/"):
                for name in group:
                    where = f"{path}/{name}"
                    kind = group.id.links.get_info(name.encode(errors="surrogateescape")).type
                    if kind != _h5py.h5l.TYPE_HARD:
                        raise WrongItem(f"{where} is a {_LINKS.get(kind, 'link')}")
                    with _reading(where):
                        found = group[name]
                        about = _h5py.h5o.get_info(found.id)
                        if (about.fileno, about.addr) in seen:
                            continue
                        seen.add((about.fileno, about.addr))
                        if isinstance(found, _h5py.Group):
                            ahead.append((where, found))
                        elif isinstance(found, _h5py.Dataset):
                            _refuse_elsewhere(found)
                            _refuse_references(where, found.id.get_type())
                        _refuse_attribute_references(where, found)

    def _find(self, name: str) -> Any:
        """What is at a path, by hard links alone; None where it is missing."""
        found = self._handle["/"] if isinstance(self._handle, _h5py.File) else self._handle
        for part in name.split("/"):
            where = f"{found.name.rstrip('/')}/{part}"
            if not isinstance(found, _h5py.Group):
                raise WrongItem(f"{found.name} is no group")
            with _reading(where):
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
        with _reading(found.name):
            _refuse_elsewhere(found)
            _ = found.dtype, found.shape
        return found

    def _numbers(self, name: str) -> Any:
        dataset = self._dataset(name)
        if dataset.dtype.kind not in "fiu":
            raise WrongItem(f"{dataset.name} holds no numbers, but {_described(dataset)}")
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


def _attribute(handle: Any, key: str) -> Any:
    with _reading(f"{handle.name}/@{key}"):
        return handle.attrs.get(key)


_LINKS: Final = {_h5py.h5l.TYPE_SOFT: "soft link", _h5py.h5l.TYPE_EXTERNAL: "link into another file"}


def _described(dataset: Any) -> str:
    return f"{dataset.dtype} of shape {dataset.shape}"


@contextmanager
def _reading(where: str) -> Generator[None]:
    """Name what is read, in whatever h5py says of it."""
    try:
        yield
    except WrongItem:
        raise
    except HDF5_ERRORS as error:
        if "truncated" in str(error):
            raise
        raise WrongItem(f"{where} cannot be read: {error}") from error


def _refuse_elsewhere(dataset: Any) -> None:
    """Refuse numbers that the file only points to: in other datasets, or in other files, which may be anything."""
    if dataset.is_virtual or dataset.external:
        raise WrongItem(f"{dataset.name} holds nothing itself: its data are elsewhere, which is not followed")


def _refuse_references(where: str, kind: Any) -> None:
    if kind.detect_class(_h5py.h5t.REFERENCE):
        raise WrongItem(f"{where} holds references")


def _refuse_attribute_references(where: str, handle: Any) -> None:
    for key in handle.attrs:
        _refuse_references(f"{where}/@{key}", handle.attrs.get_id(key).get_type())


def _refuse_hollow(dataset: Any, file_bytes: int) -> None:
    """Refuse a shape that promises far more than is stored: HDF5 makes up the rest, and fills the memory with it."""
    packed = dataset.id.get_create_plist().get_nfilters() > 0
    there = min(dataset.id.get_storage_size(), file_bytes) * (_MOST_PACKED if packed else 1)
    if dataset.nbytes > there:
        raise WrongItem(
            f"{dataset.name} is {_described(dataset)}, {dataset.nbytes} bytes, of which the file holds {there}"
        )


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
        _refuse_cut_off(path)
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
