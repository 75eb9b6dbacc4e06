"""Pictures of transmission from PNG and NPY files, which may have been made to do harm.

What is in a file is known from its first bytes, never from its name: a PostScript program that is called ``.png`` is refused and
not run. How large it will be is known from its header, and asked before any room is taken for it.
"""

import math
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from PIL import Image

from protocols import Floats, InputError
from protocols.plain_file import open_plain

MOST_CELLS: Final = 32_000_000
"""Pixels of a picture at most: four times the mirrors of the largest modulators, and less than 2 GB while it is read."""

_MOST_BYTES: Final = 8 * MOST_CELLS + 1_000_000
_PNG: Final = b"\x89PNG\r\n\x1a\n"
_NPY: Final = b"\x93NUMPY"
_OTHERS: Final = (
    (b"%!PS", "a PostScript program"),
    (b"\xc5\xd0\xd3\xc6", "a PostScript program"),
    (b"%PDF", "a PDF document"),
    (b"PK", "an archive (ZIP or NPZ)"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"BM", "a BMP picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
)
"""First bytes of what is mistaken for a picture most often."""


def read_cells(path: Path) -> Floats:
    """Read the transmission of a PNG (grey, black 0 to white 1) or of an NPY file (0 to 1).

    Returns:
        ``(rows, columns)`` transmission.

    Raises:
        InputError: no plain file, neither PNG nor NPY, damaged, larger than ``MOST_CELLS``, or values outside 0 to 1.
    """
    try:
        with open_plain(path, _MOST_BYTES) as stream:
            head = stream.read(len(_PNG))
            stream.seek(0)
            if head.startswith(_NPY):
                return _checked(_array(stream, path), path)
            if head == _PNG:
                return _checked(_grey(stream, path), path)
    except OSError as error:
        raise _refused(path, error.strerror or str(error)) from error
    raise _refused(path, next((words for start, words in _OTHERS if head.startswith(start)), "neither PNG nor NPY"))


def _grey(stream: BinaryIO, path: Path) -> Floats:
    """Decode a PNG whose size was found bearable in its header."""
    header = stream.read(24)
    if header[12:16] != b"IHDR" or len(header) < 24:
        raise _refused(path, "a PNG without its header")
    _check_size((int.from_bytes(header[20:24]), int.from_bytes(header[16:20])), path)
    stream.seek(0)
    try:
        with Image.open(stream, formats=("PNG",)) as picture:
            deep = picture.mode.startswith("I")
            grey = np.asarray(picture if deep else _opaque(picture).convert("L"))
    except Exception as error:  # whatever a decoder raises on bytes that somebody broke
        raise _refused(
            path, f"a damaged PNG: {error}", "open it in a picture viewer, and save it again as PNG"
        ) from error
    cells: Floats = grey / (65535.0 if deep else 255.0)
    return cells


def _opaque(picture: Image.Image) -> Image.Image:
    """The picture on black: where it is transparent there is no object, whatever colour is stored there."""
    if picture.mode not in {"RGBA", "LA", "PA"} and "transparency" not in picture.info:
        return picture
    painted = picture.convert("RGBA")
    return Image.alpha_composite(Image.new("RGBA", painted.size, (0, 0, 0, 255)), painted)


def _array(stream: BinaryIO, path: Path) -> Floats:
    """Read an NPY file whose header promises no more than the file holds."""
    remedy = "write it with numpy.save from a plain array of numbers"
    try:
        shape, by_columns, dtype = _npy_header(stream)
    except Exception as error:  # the header is a Python literal: it can be broken in as many ways as Python
        raise _refused(path, f"an NPY file with a broken header: {error}", remedy) from error
    if dtype.kind not in "biuf":
        raise _refused(path, f"an array of {dtype}", remedy)
    if len(shape) != 2 or min(shape) < 1:
        raise _shapeless(shape, path)
    _check_size(shape, path)
    wanted = math.prod(shape) * dtype.itemsize
    data = stream.read(wanted)
    if len(data) < wanted:
        raise _refused(path, f"{len(data)} bytes behind a header that promises {wanted}: {shape} of {dtype}", remedy)
    flat = np.frombuffer(data, dtype)
    return np.asarray(flat.reshape(shape, order="F" if by_columns else "C"), np.float64)


def _npy_header(stream: BinaryIO) -> tuple[tuple[int, ...], bool, np.dtype[np.generic]]:
    """Shape, whether columns come first, and type. Versions above 2 are for names of fields, which numbers do not have."""
    version = np.lib.format.read_magic(stream)
    if version == (1, 0):
        return np.lib.format.read_array_header_1_0(stream)
    if version == (2, 0):
        return np.lib.format.read_array_header_2_0(stream)
    raise ValueError(f"version {version[0]}.{version[1]}, where 1.0 and 2.0 are read")


def _check_size(shape: tuple[int, ...], path: Path) -> None:
    rows, columns = shape
    if not 0 < rows * columns <= MOST_CELLS:
        raise _refused(path, f"a picture of {columns} x {rows} pixels", f"make it smaller: {MOST_CELLS} pixels at most")


def _checked(cells: Floats, path: Path) -> Floats:
    if cells.ndim != 2:
        raise _shapeless(cells.shape, path)
    low, high = float(cells.min()), float(cells.max())
    if not (low >= 0 and high <= 1):
        raise InputError(
            saw=f"{path}: transmission from {low:g} to {high:g}",
            expected="0 to 1 everywhere",
            remedy="scale the array before saving it (grey values of 8 bits are divided by 255)",
        )
    return cells


def _shapeless(shape: tuple[int, ...], path: Path) -> InputError:
    return InputError(
        saw=f"{path}: an array of shape {shape}",
        expected="rows x columns of transmission",
        remedy="save one grey picture, with two dimensions",
    )


def _refused(path: Path, saw: str, remedy: str = "save the picture as PNG, or the array with numpy.save") -> InputError:
    return InputError(
        saw=f"{path}: {saw}", expected="a grey picture (PNG) or a NumPy array of numbers (NPY)", remedy=remedy
    )
