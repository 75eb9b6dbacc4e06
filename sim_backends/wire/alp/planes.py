"""Picture data: what AlpSeqPut reads, how the emulator keeps it, and what the mirrors make of it."""

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from protocols import Bytes
from sim_backends.wire.alp.codes import BINARY_BOTTOMUP, BINARY_TOPDOWN, LSB_ALIGN


@dataclass(frozen=True)
class Plane:
    """One packed bit plane, dark ends cut off and the rest compressed: some kB instead of 98,304 B."""

    offset: int
    """Number of dark bytes before ``body``."""

    body: bytes
    """zlib stream of the bytes between the first and the last lit word."""


def keep(packed: bytes) -> Plane:
    """Compress one packed plane, of whole words of 8 bytes."""
    lit = np.flatnonzero(np.frombuffer(packed, np.uint64)).tolist()  # five times as fast as to strip bytes
    first, end = (8 * lit[0], 8 * (lit[-1] + 1)) if lit else (0, 0)
    return Plane(first, zlib.compress(packed[first:end], 1))


@dataclass(frozen=True)
class Geometry:
    """The mirror array, and the memory lines behind it."""

    columns: int
    """Number of mirrors in a row."""

    rows: int
    """Number of rows of mirrors."""

    row_bytes: int
    """Bytes a row in the packed formats; padded on 1080p and WUXGA (dlp7000.md 3.8)."""

    @classmethod
    def of(cls, columns: int, rows: int) -> "Geometry":
        """Rows that are not a power of two wide are padded to the next one."""
        return cls(columns, rows, columns // 8 if columns in (1024, 2560) else (1 << (columns - 1).bit_length()) // 8)

    def unpack(self, plane: Plane) -> Bytes:
        """``(rows, columns / 8)``: the plane as the mirrors' memory holds it."""
        whole = bytearray(self.rows * self.row_bytes)
        body = zlib.decompress(plane.body)
        whole[plane.offset : plane.offset + len(body)] = body
        return np.frombuffer(bytes(whole), np.uint8).reshape(self.rows, self.row_bytes)[:, : self.columns // 8]

    def merged(self, old: Plane | None, new: Plane, rows: slice) -> Plane:
        """The old plane, dark where there is none, with these rows of the new one."""
        padding = ((0, 0), (0, self.row_bytes - self.columns // 8))
        whole = np.zeros((self.rows, self.columns // 8), np.uint8) if old is None else self.unpack(old).copy()
        whole[rows] = self.unpack(new)[rows]
        return keep(np.pad(whole, padding).tobytes())

    def unit_bytes(self, data_format: int) -> int:
        """Bytes of one unit of AlpSeqPut: a plane in the packed formats, a picture in the others."""
        packed = data_format in (BINARY_TOPDOWN, BINARY_BOTTOMUP)
        return self.rows * (self.row_bytes if packed else self.columns)

    def planes_of(self, unit: bytes, data_format: int, bit_planes: int) -> list[Plane]:
        """Turn one unit of user data into planes, the most significant first (dlp7000.md 3.8)."""
        if data_format == BINARY_TOPDOWN:
            return [keep(unit)]
        if data_format == BINARY_BOTTOMUP:
            return [keep(np.frombuffer(unit, np.uint8).reshape(self.rows, -1)[::-1].tobytes())]
        grey = np.frombuffer(unit, np.uint8).reshape(self.rows, self.columns)
        top = bit_planes - 1 if data_format == LSB_ALIGN else 7
        bits = [np.packbits((grey >> (top - plane)) & 1, axis=-1) for plane in range(bit_planes)]
        padding = ((0, 0), (0, self.row_bytes - self.columns // 8))
        return [keep(np.pad(plane, padding).tobytes()) for plane in bits]


@dataclass(frozen=True)
class View:
    """What stands between memory and mirrors: the projection controls, and the fault of wrong rows."""

    inverted: bool = False
    """Setting of ALP_PROJ_INVERSION."""

    upside_down: bool = False
    """Setting of ALP_PROJ_UPSIDE_DOWN."""

    mirrored: bool = False
    """Setting of ALP_PROJ_LEFT_RIGHT_FLIP."""

    lines: tuple[int, int] | None = None
    """First row and number of rows of ALP_SEQ_DMD_LINES; the others stay dark. None: all."""

    shift_rows: int = 0
    """Number of rows by which pictures are shown too low."""

    def of(self, memory: Bytes) -> Bytes:
        """``(rows, columns / 8)``: mirrors that show this memory."""
        mirrors = ~memory if self.inverted else memory
        if self.upside_down:
            mirrors = mirrors[::-1]
        if self.mirrored:
            mirrors = np.packbits(np.unpackbits(mirrors, axis=-1)[:, ::-1], axis=-1)
        if self.lines is not None:
            first, count = self.lines
            kept = np.zeros_like(mirrors)
            kept[first : first + count] = mirrors[first : first + count]
            mirrors = kept
        return np.roll(mirrors, self.shift_rows, axis=0) if self.shift_rows else mirrors


def mirrors_of(planes: Sequence[Plane | None], geometry: Geometry, view: View, empty: Bytes) -> Callable[[int], Bytes]:
    """Give the mirrors of each plane; -1 is all mirrors off, and a plane that was never uploaded is ``empty``."""
    dark = np.zeros((geometry.rows, geometry.columns // 8), np.uint8)

    def mirrors(index: int) -> Bytes:
        if index < 0:
            return dark
        plane = planes[index]
        return view.of(empty if plane is None else geometry.unpack(plane))

    return mirrors
