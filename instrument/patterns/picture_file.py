"""A picture from a file, made of mirrors that are on or off."""

import io
from pathlib import Path
from typing import Final

import numpy as np

from instrument.patterns.dither import floyd_steinberg
from protocols import Bytes, InputError
from protocols.plain_file import NoPlainFile, read_plain

_MOST_BYTES: Final = 64_000_000
_MOST_PIXELS: Final = 50_000_000


def picture_of_file(path: Path, size: int) -> Bytes:
    """Read a picture, fit it into the field, in the middle, and dither its greys.

    Args:
        path: any format that Pillow reads; transparency is not looked at.
        size: image pixels a side.

    Returns:
        ``(size, size)`` of 0 and 1, row = y (down).

    Raises:
        InputError: no such file, no picture, or one that is too large.
    """
    from PIL import Image, UnidentifiedImageError  # noqa: PLC0415 - few pictures are files

    try:
        with Image.open(io.BytesIO(read_plain(path, _MOST_BYTES))) as opened:
            if opened.width * opened.height > _MOST_PIXELS:
                raise _refused(path, f"{opened.width} x {opened.height} pixels")
            grey = opened.convert("L")
    except (UnidentifiedImageError, Image.DecompressionBombError, SyntaxError, ValueError) as error:
        raise _refused(path, f"no picture ({error})") from error
    except NoPlainFile as error:
        raise _refused(path, str(error.strerror)) from error
    except OSError as error:
        raise _refused(path, error.strerror or str(error)) from error
    scale = size / max(grey.size)
    width, height = (max(1, round(side * scale)) for side in grey.size)
    field = np.zeros((size, size))
    top, left = (size - height) // 2, (size - width) // 2
    fitted = grey.resize((width, height), Image.Resampling.BOX)
    field[top : top + height, left : left + width] = np.asarray(fitted, np.float64) / 255
    return floyd_steinberg(field)


def _refused(path: Path, saw: str) -> InputError:
    return InputError(
        saw=f"{path}: {saw}",
        expected=f"a picture of at most {_MOST_PIXELS // 1_000_000} megapixels",
        remedy="name a PNG, or one of the pictures that `kinopix show --help` lists",
    )
