"""An image as the controller takes it apart: 48 bytes of header, then pixels in one of three codes (sheet, section 4)."""

import struct
from dataclasses import dataclass

import numpy as np

from protocols import Bytes

HEADER = 48
_SIGNATURE = b"Spld"


class BadImage(ValueError):
    """What cannot be decoded."""


@dataclass(frozen=True, eq=False)
class Picture:
    """Pixels, each distinct line once."""

    lines: Bytes
    """``(lines, columns, 3)``."""

    which: tuple[int, ...]
    """Line of each row."""

    def plane(self, bit: int, colour_order: str) -> Bytes:
        """Give one of the 24 bit planes as packed mirrors ``(rows, columns / 8)``."""
        byte = {"rgb": "bgr", "grb": "bgr"}[colour_order][bit // 8]
        channel = self.lines[:, :, colour_order.index(byte)]
        packed = np.packbits(channel >> (bit % 8) & 1, axis=1)
        return packed[list(self.which)]


def decode(data: bytes, columns: int, rows: int) -> Picture:
    """Take an image apart.

    Raises:
        BadImage: a wrong signature, another geometry, a size that does not fit, an unknown compression, a code that breaks off.
    """
    if len(data) < HEADER or data[:4] != _SIGNATURE:
        raise BadImage("signature")
    width, height, size = struct.unpack("<HHI", data[4:12])
    compression = data[25]
    body = data[HEADER:]
    if (width, height) != (columns, rows) or size != len(body):
        raise BadImage("geometry or size")
    if compression == 0:
        if len(body) != rows * columns * 3:
            raise BadImage("size of the pixels")
        return Picture(np.frombuffer(body, np.uint8).reshape(rows, columns, 3), tuple(range(rows)))
    if compression != 2:
        raise BadImage("compression")
    return _enhanced(body, columns, rows)


def _enhanced(body: bytes, columns: int, rows: int) -> Picture:
    lines: list[bytes] = []
    which: list[int] = []
    row = bytearray()
    copied = 0
    at = 0

    def number() -> int:
        nonlocal at
        value = body[at]
        at += 1
        if value & 0x80:
            value = value & 0x7F | body[at] << 7
            at += 1
        return value

    try:
        while True:
            n = number()
            if n:
                row += body[at : at + 3] * n
                at += 3
            else:
                n = number()
                if n == 1:
                    n = number()
                    if n == 0:
                        break
                    above = lines[which[-1]][len(row) : len(row) + 3 * n] if which else b""
                    copied += n
                    row += above
                elif n == 0:
                    row += bytes(3 * columns - len(row))  # end of line
                else:
                    row += body[at : at + 3 * n]
                    at += 3 * n
            if len(row) > 3 * columns:
                raise BadImage("a run over the end of a line")
            if len(row) == 3 * columns:
                if copied == columns:
                    which.append(which[-1])
                else:
                    which.append(len(lines))
                    lines.append(bytes(row))
                row, copied = bytearray(), 0
    except IndexError:
        raise BadImage("a code that breaks off") from None
    if row or len(which) != rows:
        raise BadImage(f"{len(which)} rows")
    pixels = np.frombuffer(b"".join(lines), np.uint8).reshape(len(lines), columns, 3)
    return Picture(pixels, tuple(which))
