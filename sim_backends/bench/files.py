"""Pictures and trajectories from files, refused with the file's name where they cannot be used."""

import csv
import math
from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from protocols import Floats, InputError
from sim_backends.bench.image import AreaImage
from sim_backends.bench.objects import BUILT_INS, NOTHING

_HEADER = ["t_s", "x_px", "y_px"]
_GAP = 10.0
"""A step longer than so many median steps is a gap: there, linear interpolation would be an invention."""


def load_object(
    name: str,
    folder: Path,
    *,
    key: str,
    image_size: int,
    height_px: float | None,
    centre_px: tuple[float, float] | None,
) -> AreaImage:
    """Give the object that ``[scene] <key>`` names, in its place on an image of ``image_size`` px.

    Args:
        name: a built-in name, or a path relative to ``folder``.
        folder: folder of bench.toml.
        key: for error messages.
        image_size: pixels a side of the image.
        height_px: height of the object; None: 36 px in 128 for a built-in, the longer side fills the image for a file.
        centre_px: column and row of its centre; None: for a built-in a quarter of the image from the upper left corner,
            with its cells on whole pixels, for a file the middle of the image.

    Raises:
        InputError: no such built-in or file, not a picture, values outside 0 to 1, or no light at all.
    """
    if name in BUILT_INS:
        drawing = BUILT_INS[name](height_px or image_size * 36 / 128)
        if name != NOTHING:
            _check_light(drawing.cells, f"[scene] {key} = '{name}'")
        height, width = (side * drawing.cell_px for side in drawing.cells.shape)
        if centre_px is None:
            left, top = round(image_size / 4 - width / 2), round(image_size / 4 - height / 2)
            return AreaImage(drawing.cells, drawing.cell_px, left, top)
        return AreaImage(drawing.cells, drawing.cell_px, centre_px[0] - width / 2, centre_px[1] - height / 2)
    cells = _load_cells(folder / name, f"[scene] {key}")
    cell_px = image_size / max(cells.shape) if height_px is None else height_px / len(cells)
    height, width = (side * cell_px for side in cells.shape)
    x_px, y_px = centre_px or (image_size / 2, image_size / 2)
    return AreaImage(cells, cell_px, x_px - width / 2, y_px - height / 2)


def _load_cells(path: Path, key: str) -> Floats:
    if not path.is_file():
        raise InputError(
            saw=f"{key} = '{path.name}', which is neither a built-in object nor a file in {path.parent}",
            expected=f"one of {', '.join(sorted(BUILT_INS))}, or a PNG or NPY file",
            remedy="correct the name, or give the path relative to bench.toml",
        )
    cells = _load_npy(path) if path.suffix.lower() == ".npy" else _load_picture(path)
    _check_light(cells, str(path))
    return cells


def _check_light(cells: Floats, where: str) -> None:
    if not cells.any():
        raise InputError(
            saw=f"{where}: nothing in it lets light through",
            expected="an object with some transmission above 0",
            remedy="check that the object is bright, its surroundings are black, and it is not too small to be drawn",
        )


def _load_picture(path: Path) -> Floats:
    try:
        with Image.open(path) as picture:
            deep = picture.mode.startswith("I")
            grey = np.asarray(picture if deep else _opaque(picture).convert("L"), np.float64)
    except (UnidentifiedImageError, OSError, Image.DecompressionBombError, SyntaxError) as error:
        raise InputError(
            saw=f"{path}: {error}",
            expected="a grey picture (PNG) or a NumPy array (NPY)",
            remedy="open the file in a picture viewer, and save it again as PNG",
        ) from error
    return _checked(grey / (65535.0 if deep else 255.0), path)


def _opaque(picture: Image.Image) -> Image.Image:
    """The picture on black: where it is transparent there is no object, whatever colour is stored there."""
    if picture.mode not in {"RGBA", "LA", "PA"} and "transparency" not in picture.info:
        return picture
    painted = picture.convert("RGBA")
    return Image.alpha_composite(Image.new("RGBA", painted.size, (0, 0, 0, 255)), painted)


def _load_npy(path: Path) -> Floats:
    try:
        loaded = np.load(path, allow_pickle=False)
        if loaded.dtype.kind not in "biuf":
            raise TypeError(f"an array of {loaded.dtype}")
        cells = np.asarray(loaded, np.float64)
    except (ValueError, OSError, EOFError, TypeError) as error:
        raise InputError(
            saw=f"{path}: {error}",
            expected="a NumPy array of numbers",
            remedy="write it with numpy.save from a plain array of numbers",
        ) from error
    return _checked(cells, path)


def _checked(cells: Floats, path: Path) -> Floats:
    if cells.ndim != 2 or not cells.size:
        raise InputError(
            saw=f"{path}: an array of shape {cells.shape}",
            expected="rows x columns of transmission",
            remedy="save one grey picture, with two dimensions",
        )
    low, high = float(cells.min()), float(cells.max())
    if not (low >= 0 and high <= 1):
        raise InputError(
            saw=f"{path}: transmission from {low:g} to {high:g}",
            expected="0 to 1 everywhere",
            remedy="scale the array before saving it (grey values of 8 bits are divided by 255)",
        )
    return cells


def load_trajectory(path: Path) -> tuple[Floats, Floats]:
    """Read a trajectory CSV with the header ``t_s,x_px,y_px``.

    Returns:
        ``(rows,)`` times in seconds, and ``(rows, 2)`` displacements x, y in px.

    Raises:
        InputError: no file, another header, a cell that is not a number, times that do not increase, or a gap in time.
            Names the file and the line.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise _refused(
            str(path), str(error), "a text file with the header t_s,x_px,y_px", "correct the path"
        ) from error
    lines = [
        (number, row) for number, row in enumerate(csv.reader(text.splitlines()), 1) if any(c.strip() for c in row)
    ]
    if not lines or [cell.strip() for cell in lines[0][1]] != _HEADER:
        got = f"'{','.join(lines[0][1])}'" if lines else "nothing"
        raise _refused(f"{path}, line 1", got, "the header t_s,x_px,y_px", "write these three names in the first line")
    table = np.array([_numbers(path, number, row) for number, row in lines[1:]])
    if not len(table):
        raise _refused(str(path), "a header and no rows", "one row or more", "write the displacements below the header")
    _check_times(path, [number for number, _ in lines[1:]], table[:, 0])
    return table[:, 0], table[:, 1:]


def _numbers(path: Path, line: int, row: list[str]) -> list[float]:
    try:
        values = [float(cell) for cell in row]
    except ValueError:
        values = []
    if len(values) != len(_HEADER) or not all(map(math.isfinite, values)):
        raise _refused(
            f"{path}, line {line}",
            f"'{','.join(row)}'",
            "three finite numbers: t_s, x_px, y_px",
            "correct or remove the line",
        )
    return values


def _check_times(path: Path, lines: list[int], time_s: Floats) -> None:
    steps = np.diff(time_s)
    back = np.flatnonzero(steps <= 0)
    if len(back):
        at = int(back[0]) + 1
        raise _refused(
            f"{path}, line {lines[at]}",
            f"t_s = {time_s[at]:g} after {time_s[at - 1]:g}",
            "times that increase from row to row",
            "sort the rows by t_s and remove doubles",
        )
    if len(time_s) < 4:
        return
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > _GAP * usual)
    if len(gaps):
        at = int(gaps[0])
        raise _refused(
            f"{path}, line {lines[at + 1]}",
            f"a gap in time of {steps[at]:g} s where the rows are usually {usual:g} s apart",
            f"no step above {_GAP:g} times the usual one",
            "fill in the missing rows, or cut the trajectory before the gap",
        )


def _refused(where: str, saw: str, expected: str, remedy: str) -> InputError:
    return InputError(saw=f"{where}: {saw}", expected=expected, remedy=remedy)
