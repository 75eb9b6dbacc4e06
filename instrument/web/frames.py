"""The binary frames of the page: what stands in them, byte by byte.

Everything is little-endian. A frame begins with a head of 32 bytes:

| bytes | what |
|---|---|
| 0 to 3 | ``KNPX`` |
| 4, 5 | version of this layout, 2 |
| 6, 7 | kind: 1 an image, 2 a part of the path |
| 8 to 11 | sequence number of the image; of a path, its generation: with another generation the path begins anew |
| 12 to 15 | images that this viewer has missed so far, because newer ones came |
| 16 to 23 | when it was sent, seconds since 1970 |
| 24 to 31 | when the newest count in it was handed over, likewise |

An image goes on with columns and rows (16 bits each), the number of frames that it is made of (32), the value that is white (a
32-bit float), and a byte a pixel, row by row. A path goes on with the index of its first point (32), and for each point five
32-bit floats: seconds since the first edge, x and y in px, and the standard uncertainty of both, NaN where none is known.
"""

import struct
from typing import Final

import numpy as np

from instrument.views import white_of
from protocols import Floats

VERSION: Final = 2
IMAGE: Final = 1
PATH: Final = 2

_HEAD: Final = struct.Struct("<4sHHIIdd")
_IMAGE: Final = struct.Struct("<HHIf")
_PATH: Final = struct.Struct("<I")
_WHITE: Final = 255
_DARK: Final = 1e-30


def image_body(image: Floats, frames: int) -> bytes:
    """Give an image as it is sent: 0 is black; white is what all but 2 of 1000 pixels stay below, so that a few do not darken it.

    Args:
        image: ``(rows, columns)``.
        frames: number of frames that it is made of.
    """
    rows, columns = image.shape
    shown = np.nan_to_num(image)
    top = white_of(shown)
    grey = np.clip(shown / max(top, _DARK), 0.0, 1.0) * _WHITE
    return _IMAGE.pack(columns, rows, frames, top) + grey.round().astype(np.uint8).tobytes()


def path_body(first: int, points: Floats) -> bytes:
    """Give a part of the path as it is sent.

    Args:
        first: index of the first point.
        points: ``(n, 5)`` seconds, x and y in px, and the standard uncertainty of both.
    """
    return _PATH.pack(first) + np.ascontiguousarray(points, "<f4").tobytes()


def frame(kind: int, sequence: int, body: bytes, *, skipped: int, sent_s: float, made_s: float) -> bytes:
    """Give one frame: the head, and the body behind it."""
    return _HEAD.pack(b"KNPX", VERSION, kind, sequence & 0xFFFFFFFF, skipped & 0xFFFFFFFF, sent_s, made_s) + body
