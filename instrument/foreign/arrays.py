"""A vector of Hadamard coefficients in an NPZ, NPY or MAT file, of whatever program."""

import io
import zipfile
from pathlib import Path
from typing import Any, Final

import numpy as np

from instrument.config import RunTable
from instrument.foreign.pairs import ORDERS, HadamardPairs, side_of
from instrument.patterns import HadamardOrder, hadamard_order
from protocols import Floats, InputError
from protocols.plain_file import NoPlainFile, path_of, read_plain

MOST_BYTES: Final = 2_000_000_000
"""Longest file that is read, and most bytes of what is packed in it."""


def arrays_of(path: Path) -> dict[str, Any]:
    """Give the arrays of numbers in a file by name. Nothing in it is carried out.

    Raises:
        InputError: no such file, too large, or of another kind.
    """
    try:
        data = read_plain(path_of(path), MOST_BYTES)
        return _READERS[path.suffix.lower()](data)
    except KeyError:
        raise _unreadable(path, "a file of another kind") from None
    except NoPlainFile as error:
        raise _unreadable(path, str(error.strerror)) from error
    except OSError as error:
        raise _unreadable(path, error.strerror or str(error)) from error
    except (ValueError, TypeError, EOFError, NotImplementedError, zipfile.BadZipFile, MemoryError) as error:
        raise _unreadable(path, f"no sound {path.suffix} file ({error})") from error


def read_array(path: str | Path, key: str | None = None, order: str | None = None) -> HadamardPairs:
    """Read one vector: a coefficient a pattern (I_H+ - I_H-), or the light of each pattern and its complement in turn.

    Which of both it is, its length tells: m^2 or 2 m^2 numbers for an image of m x m, m a power of two.

    Args:
        path: the file.
        key: name of the array; None where there is one only.
        order: in which the patterns were shown. No file tells, and with a wrong one the image is noise.

    Raises:
        InputError: no such array, another shape, or no order.
    """
    path = path_of(path)
    arrays = arrays_of(path)
    numbers = {name: array for name, array in arrays.items() if getattr(array, "dtype", np.dtype("O")).kind in "iuf"}
    if not numbers:
        raise _unreadable(path, f"no array of numbers, but {', '.join(arrays) or 'nothing'}")
    name = next(iter(numbers)) if key is None and len(numbers) == 1 else key
    if name is None or name not in numbers:
        shown = ", ".join(f"{each} {array.shape}" for each, array in list(numbers.items())[:20])
        raise InputError(
            saw=f"{'no array of that name' if name else 'several arrays'} in {path.name}",
            expected=f"one of {shown}{', ...' if len(numbers) > 20 else ''}",
            remedy="name one with --key",
        )
    vector = np.squeeze(numbers[name])
    size, split = (side_of(vector.size), False) if side_of(vector.size) else (side_of(vector.size // 2), True)
    if vector.ndim != 1 or size is None or (split and vector.size % 2):
        raise InputError(
            saw=f"{name} of shape {numbers[name].shape} in {path.name}",
            expected="a vector of m^2 Hadamard coefficients, or of 2 m^2 values, a pattern and its complement in turn, "
            "with m = 8, 16, 32 and so on",
            remedy="name another array with --key; coefficients of other patterns, such as wavelets, have no scheme here",
        )
    shown = _order(order, name)
    light = np.asarray(vector, np.float64)
    values, missing = _split(light) if split else _differential(light)
    return HadamardPairs(
        image_size=size,
        pairs=hadamard_order(size, shown),
        values=values,
        picture_time_s=None,
        about=RunTable(title=f"{path.stem} {name}"[:200], notes=f"converted from {path.name}, array {name}"),
        missing=missing,
        origin={"file": path.name, "array": name, "order": shown},
    )


def _order(order: str | None, name: str) -> HadamardOrder:
    """The order that was named, if it is one that needs no seed."""
    for known in ORDERS:
        if known == order:
            return known
    raise InputError(
        saw=f"the order {order!r}" if order else f"{name} without the order of its patterns, which no such file tells",
        expected=f"one of {', '.join(ORDERS)}",
        remedy="give --order, as it is where the data come from: with a wrong order the image is noise",
    )


def _split(light: Floats) -> tuple[Floats, tuple[str, ...]]:
    return light.reshape(-1, 2), ()


def _differential(coefficients: Floats) -> tuple[Floats, tuple[str, ...]]:
    """Pairs with these differences. The sum of a pair is the total light, which is the coefficient of the all-on pattern."""
    total = coefficients[0]
    pairs = np.stack([total + coefficients, total - coefficients], axis=1) / 2
    return pairs, ("the file has differences only: every pair adds up to the first coefficient, without noise",)


def _npz(data: bytes) -> dict[str, Any]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        packed = sum(member.file_size for member in archive.infolist())
    if packed > MOST_BYTES:
        message = f"it holds {packed} bytes, of at most {MOST_BYTES}"
        raise ValueError(message)
    with np.load(io.BytesIO(data), allow_pickle=False) as opened:
        return {name: opened[name] for name in opened.files}


def _npy(data: bytes) -> dict[str, Any]:
    return {"array": np.load(io.BytesIO(data), allow_pickle=False)}


def _mat(data: bytes) -> dict[str, Any]:
    from scipy.io import loadmat  # noqa: PLC0415 - few files are of MATLAB
    from scipy.io.matlab import MatReadError  # noqa: PLC0415

    try:
        opened: Any = io.BytesIO(data)  # which the stubs of SciPy leave out
        found: dict[str, Any] = loadmat(opened)
    except MatReadError as error:
        raise ValueError(error) from error
    return {name: array for name, array in found.items() if not name.startswith("__")}


_READERS: Final = {".npz": _npz, ".npy": _npy, ".mat": _mat}


def _unreadable(path: Path, saw: str) -> InputError:
    return InputError(
        saw=f"{path}: {saw}",
        expected="an NPZ or NPY file of numpy, a MAT file up to version 7.2, or a pair of files of SPAS",
        remedy="name such a file",
    )
