"""What in a file is sound: files come from anywhere, so that whatever is read is looked at first."""

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import h5py  # pyright: ignore[reportMissingTypeStubs]

_h5py: Any = h5py

HDF5_ERRORS = (OSError, RuntimeError, LookupError, ValueError, TypeError, ArithmeticError, AttributeError, MemoryError)
"""What h5py raises for a file that is damaged."""

_MOST_PACKED: Final = 200
"""How much smaller than its numbers a compressed dataset may be. Counts shrink to a tenth."""


class WrongItem(ValueError):
    """Something in the file is not what a recording has there. The message begins with its path inside the file."""


_LINKS: Final = {_h5py.h5l.TYPE_SOFT: "soft link", _h5py.h5l.TYPE_EXTERNAL: "link into another file"}


def described(dataset: Any) -> str:
    """Give type and shape of a dataset in words."""
    return f"{dataset.dtype} of shape {dataset.shape}"


@contextmanager
def reading(where: str) -> Generator[None]:
    """Name what is read, in whatever h5py says of it."""
    try:
        yield
    except WrongItem:
        raise
    except HDF5_ERRORS as error:
        if "truncated" in str(error):
            raise
        raise WrongItem(f"{where} cannot be read: {error}") from error


def refuse_elsewhere(dataset: Any) -> None:
    """Refuse numbers that the file only points to: in other datasets, or in other files, which may be anything."""
    if dataset.is_virtual or dataset.external:
        raise WrongItem(f"{dataset.name} holds nothing itself: its data are elsewhere, which is not followed")


def refuse_references(where: str, kind: Any) -> None:
    """Refuse a type that points to other objects."""
    if kind.detect_class(_h5py.h5t.REFERENCE):
        raise WrongItem(f"{where} holds references")


def refuse_attribute_references(where: str, handle: Any) -> None:
    """Refuse such types in the attributes of an object."""
    for key in handle.attrs:
        refuse_references(f"{where}/@{key}", handle.attrs.get_id(key).get_type())


def refuse_hollow(dataset: Any, file_bytes: int) -> None:
    """Refuse a shape that promises far more than is stored: HDF5 makes up the rest, and fills the memory with it."""
    packed = dataset.id.get_create_plist().get_nfilters() > 0
    there = min(dataset.id.get_storage_size(), file_bytes) * (_MOST_PACKED if packed else 1)
    if dataset.nbytes > there:
        raise WrongItem(
            f"{dataset.name} is {described(dataset)}, {dataset.nbytes} bytes, of which the file holds {there}"
        )


def refuse_cut_off(path: Path) -> None:
    """Refuse a file that is shorter than its superblock says, as HDF5 does itself for files that are not ``swmr``.

    Versions 2 and 3 hold the address of the end in bytes 28 to 35 (HDF5 file format specification, section II.A).
    """
    with path.open("rb") as file:
        start = file.read(36)
    size, end = path.stat().st_size, int.from_bytes(start[28:36], "little")
    if len(start) < 36 or (start[8] >= 2 and size < end):
        raise OSError(f"truncated: it goes on to byte {end}, the file ends at {size}")


def end_of_chunks(dataset: Any) -> int:
    """First byte after the last chunk of a dataset; 0 for one that is not stored in chunks."""
    ends = [0]
    if dataset.chunks is not None:

        def note(chunk: Any) -> None:
            ends.append(chunk.byte_offset + chunk.size)

        dataset.id.chunk_iter(note)
    return max(ends)


def refuse_foreign(root: Any) -> None:
    """Make sure that everything in the file is held by the file itself, so that it can be copied.

    Raises:
        WrongItem: names the first soft or external link, virtual dataset, dataset in other files, or object reference.
    """
    seen: set[tuple[int, int]] = set()
    ahead: list[tuple[str, Any]] = [("", root)]
    with reading("/"):
        refuse_attribute_references("", root)
    while ahead:
        path, group = ahead.pop()
        with reading(path or "/"):
            for name in group:
                where = f"{path}/{name}"
                kind = group.id.links.get_info(name.encode(errors="surrogateescape")).type
                if kind != _h5py.h5l.TYPE_HARD:
                    raise WrongItem(f"{where} is a {_LINKS.get(kind, 'link')}")
                with reading(where):
                    found = group[name]
                    about = _h5py.h5o.get_info(found.id)
                    if (about.fileno, about.addr) in seen:
                        continue
                    seen.add((about.fileno, about.addr))
                    if isinstance(found, _h5py.Group):
                        ahead.append((where, found))
                    elif isinstance(found, _h5py.Dataset):
                        refuse_elsewhere(found)
                        refuse_references(where, found.id.get_type())
                    refuse_attribute_references(where, found)
