"""A file as its writer left it when it died, shown to HDF5 as one that was closed.

HDF5 marks a file that is being written in its superblock, and opens it only in its reading mode for files that are written at the
same time. In that mode it takes a checksum that does not agree for a write on its way, and tries again, a hundred times at
growing intervals: over a minute for each damaged place, deaf to signals. Nobody writes a file that is left, so it is read
as a closed one: of the superblock the mark is taken away and the end of the file put in, in what is read and not on the disk.
"""

import struct
from io import SEEK_END, SEEK_SET, RawIOBase
from typing import Any, BinaryIO, Final

_SUPERBLOCK: Final = 48
"""Bytes of a superblock of version 3 with addresses of 8 bytes: the last four are its checksum."""

_VERSION, _ADDRESS_BYTES, _FLAGS, _END = 8, 9, 11, 28
_WRITTEN_WHILE_READ: Final = 4
"""Flag of a file that is written while others read (HDF5 file format specification, section II.A)."""

_WORD: Final = 0xFFFFFFFF


class LeftOpen(RawIOBase):
    """The content of such a file, to be read."""

    def __init__(self, content: BinaryIO) -> None:
        """Take over an open file, or bytes in memory, at its beginning."""
        super().__init__()
        self._content = content
        start = content.read(_SUPERBLOCK)
        self.is_marked = (
            len(start) == _SUPERBLOCK
            and start[_VERSION] == 3
            and start[_ADDRESS_BYTES] == 8
            and bool(start[_FLAGS] & _WRITTEN_WHILE_READ)
            and struct.unpack("<I", start[-4:]) == (lookup3(start[:-4]),)
        )
        """Whether it is one: it was being written while others could read, and its superblock is whole."""
        self._start = self._closed(bytearray(start)) if self.is_marked else b""
        content.seek(0)

    def _closed(self, start: bytearray) -> bytes:
        """The superblock of a file that was closed."""
        start[_FLAGS] = 0
        start[_END : _END + 8] = struct.pack("<Q", self._content.seek(0, SEEK_END))
        start[-4:] = struct.pack("<I", lookup3(bytes(start[:-4])))
        return bytes(start)

    def readable(self) -> bool:
        """It is."""
        return True

    def seekable(self) -> bool:
        """It is."""
        return True

    def seek(self, offset: int, whence: int = SEEK_SET) -> int:
        """Go to a byte."""
        return self._content.seek(offset, whence)

    def tell(self) -> int:
        """Give the next byte."""
        return self._content.tell()

    def readinto(self, buffer: Any) -> int:
        """Read on, with the superblock of a closed file."""
        where, into = self.tell(), memoryview(buffer).cast("B")
        part = self._content.read(len(into))
        part = self._start[where : where + len(part)] + part[max(0, len(self._start) - where) :]
        into[: len(part)] = part
        return len(part)


def lookup3(data: bytes) -> int:
    """Give the checksum of HDF5's metadata: Bob Jenkins' lookup3 (``hashlittle``, 2006), which starts from 0."""
    a = b = c = (0xDEADBEEF + len(data)) & _WORD
    while len(data) > 12:
        x, y, z = struct.unpack_from("<3I", data)
        a, b, c = _mixed(a + x & _WORD, b + y & _WORD, c + z & _WORD)
        data = data[12:]
    if not data:
        return c
    x, y, z = struct.unpack("<3I", data.ljust(12, b"\0"))
    return _final(a + x & _WORD, b + y & _WORD, c + z & _WORD)


def _rotated(word: int, by: int) -> int:
    return (word << by | word >> (32 - by)) & _WORD


def _mixed(a: int, b: int, c: int) -> tuple[int, int, int]:
    for by in (4, 6, 8, 16, 19, 4):  # each time the three change their parts
        a = (a - c & _WORD) ^ _rotated(c, by)
        c = c + b & _WORD
        a, b, c = b, c, a
    return a, b, c


def _final(a: int, b: int, c: int) -> int:
    for by in (14, 11, 25, 16, 4, 14, 24):
        c = (c ^ b) - _rotated(b, by) & _WORD
        a, b, c = b, c, a
    return b
