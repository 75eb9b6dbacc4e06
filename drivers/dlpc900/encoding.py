"""Bit planes into the images that the controller takes: 24 planes a picture, compressed by runs (fact sheet, section 4).

A picture's pixel has three bytes; plane ``p`` of the 24 is bit ``p % 8`` of one of them. Which byte holds which planes is the
order of colours, a setting. Enhanced run-length code: ``n pixel`` repeats, ``00 n pixels`` as they are, ``00 01 n`` as in the
line above.
"""

import struct
from collections.abc import Iterator, Sequence
from typing import Final, Literal, TypeAlias

import numpy as np

from drivers.dlpc900.constants import PATTERNS_PER_IMAGE
from protocols import Bytes

ColourOrder: TypeAlias = Literal["rgb", "grb"]
"""Order of a pixel's bytes: planes 0 to 7 are in blue, 8 to 15 in green, 16 to 23 in red."""

_PLACES: Final = {"rgb": (2, 1, 0), "grb": (2, 0, 1)}
"""Byte of planes 0 to 7, of 8 to 15, of 16 to 23."""

_END: Final = b"\x00\x01\x00"
_UNCOMPRESSED, _ENHANCED = 0, 2


def image(planes: Sequence[Bytes], order: ColourOrder) -> bytes:
    """Give header and data of one image.

    Args:
        planes: up to 24 packed bit planes ``(rows, columns / 8)``, the leftmost mirror in the highest bit.
        order: of the colour bytes.
    """
    rows, columns = planes[0].shape[0], 8 * planes[0].shape[1]
    lines, which = _distinct_lines(planes)
    pixels = _pixels(lines, len(planes), columns, order)
    data = _enhanced(pixels, which, columns)
    compression = _ENHANCED
    if len(data) >= rows * columns * 3:
        data, compression = pixels[which].tobytes(), _UNCOMPRESSED
    header = struct.pack(
        "<4sHHI8s4sBBB21s", b"Spld", columns, rows, len(data), b"\xff" * 8, b"", 0, compression, 1, b""
    )
    return header + data


def _distinct_lines(planes: Sequence[Bytes]) -> tuple[Bytes, list[int]]:
    """Give the lines that differ from the one above, ``(lines, planes, bytes)``, and which of them each row is."""
    stack = np.stack(planes, axis=1)
    new = np.ones(len(stack), bool)
    new[1:] = (stack[1:] != stack[:-1]).any(axis=(1, 2))
    return stack[new], (np.cumsum(new) - 1).tolist()


def _pixels(lines: Bytes, n_planes: int, columns: int, order: ColourOrder) -> Bytes:
    """Give ``(lines, columns, 3)`` of packed lines ``(lines, planes, bytes)``."""
    bits = np.unpackbits(lines, axis=-1, count=columns)
    pixels = np.zeros((len(lines), columns, 3), np.uint8)
    for plane in range(min(n_planes, PATTERNS_PER_IMAGE)):
        pixels[:, :, _PLACES[order][plane // 8]] |= bits[:, plane] << (plane % 8)
    return pixels


def _enhanced(pixels: Bytes, which: Sequence[int], columns: int) -> bytes:
    """Compress the rows of an image; the code of each distinct line is worked out once."""
    above = b"\x00\x01" + _number(columns)
    code = bytearray()
    before = -1
    for line in which:
        code += above if line == before else _line(pixels[line])
        before = line
    code += _END
    return bytes(code + bytes(-len(code) % 4))


def _line(pixels: Bytes) -> bytes:
    """Compress one line: runs of two and more are repeated, what lies between them is written out."""
    changes = np.flatnonzero((pixels[1:] != pixels[:-1]).any(axis=1)) + 1
    starts = np.concatenate([[0], changes])
    lengths = np.diff(np.append(starts, len(pixels)))
    code = bytearray()
    for first, n, run in _stretches(starts.tolist(), lengths.tolist()):
        if run or n == 1:
            code += _number(n) + pixels[first].tobytes()
        else:
            code += b"\x00" + _number(n) + pixels[first : first + n].tobytes()
    return bytes(code)


def _stretches(starts: Sequence[int], lengths: Sequence[int]) -> Iterator[tuple[int, int, bool]]:
    """Give first pixel and length of each stretch, and whether it is one colour; single pixels in a row are one stretch."""
    single_from, singles = 0, 0
    for start, length in zip(starts, lengths, strict=True):
        if length == 1:
            if not singles:
                single_from = start
            singles += 1
            continue
        if singles:
            yield single_from, singles, False
            singles = 0
        yield start, length, True
    if singles:
        yield single_from, singles, False


def _number(n: int) -> bytes:
    """Give a length in one byte, or in two from 128 on.

    >>> _number(0x1234).hex()
    'b424'
    """
    return bytes([n]) if n < 0x80 else bytes([n & 0x7F | 0x80, n >> 7])
