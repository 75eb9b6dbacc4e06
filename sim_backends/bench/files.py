"""Pictures and trajectories from files, refused with the file's name where they cannot be used."""

import csv
import math
from pathlib import Path

import numpy as np

from protocols import Floats, InputError
from protocols.plain_file import read_plain
from sim_backends.bench.image import AreaImage
from sim_backends.bench.objects import BUILT_INS, NOTHING
from sim_backends.bench.pictures import read_cells

_HEADER = ["t_s", "x_px", "y_px"]
_GAP = 10.0
"""A step longer than so many median steps is a gap: there, linear interpolation would be an invention."""
_MOST_BYTES = 32_000_000
_MOST_ROWS = 1_000_000
_LARGEST = 1e6  # of a time in s and of a displacement in px
_SHOWN = 60  # characters of a row that is quoted


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
    cells = _load_cells(folder / name, f"[scene] {key} = '{name}'")
    cell_px = image_size / max(cells.shape) if height_px is None else height_px / len(cells)
    height, width = (side * cell_px for side in cells.shape)
    x_px, y_px = centre_px or (image_size / 2, image_size / 2)
    return AreaImage(cells, cell_px, x_px - width / 2, y_px - height / 2)


def _load_cells(path: Path, key: str) -> Floats:
    if not _is_there(path):
        raise InputError(
            saw=f"{key}, which is neither a built-in object nor a file in {path.parent}",
            expected=f"one of {', '.join(sorted(BUILT_INS))}, or a PNG or NPY file",
            remedy="correct the name, or give the path relative to bench.toml",
        )
    cells = read_cells(path)
    _check_light(cells, str(path))
    return cells


def _is_there(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # a name that is too long, a folder that may not be looked into: opening it says which
        return True


def _check_light(cells: Floats, where: str) -> None:
    if not cells.any():
        raise InputError(
            saw=f"{where}: nothing in it lets light through",
            expected="an object with some transmission above 0",
            remedy="check that the object is bright, its surroundings are black, and it is not too small to be drawn",
        )


def load_trajectory(path: Path) -> tuple[Floats, Floats]:
    """Read a trajectory CSV with the header ``t_s,x_px,y_px``.

    Returns:
        ``(rows,)`` times in seconds, and ``(rows, 2)`` displacements x, y in px.

    Raises:
        InputError: no plain file or one above 32 MB, another header, a cell that is not a number, a number beyond a million,
            more than a million rows, times that do not increase, or a gap in time. Names the file and the line.
    """
    expected = "a text file with the header t_s,x_px,y_px"
    try:
        text = read_plain(path, _MOST_BYTES).decode("utf-8-sig")
    except OSError as error:
        raise _refused(str(path), error.strerror or str(error), expected, "correct the path") from error
    except UnicodeDecodeError as error:
        raise _refused(str(path), "bytes that are no text in UTF-8", expected, "save it again as UTF-8") from error
    try:
        rows = enumerate(csv.reader(text.splitlines()), 1)
        lines = [(number, row) for number, row in rows if any(c.strip() for c in row)]
    except csv.Error as error:
        raise _refused(str(path), str(error), expected, "write one row of three numbers a line") from error
    if len(lines) > _MOST_ROWS + 1:
        remedy = "leave out rows: the displacement is interpolated between them"
        raise _refused(str(path), f"{len(lines) - 1} rows", f"{_MOST_ROWS} rows at most", remedy)
    if not lines or [cell.strip() for cell in lines[0][1]] != _HEADER:
        got = _quoted(lines[0][1]) if lines else "nothing"
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
        expected = "three finite numbers: t_s, x_px, y_px"
        raise _refused(f"{path}, line {line}", _quoted(row), expected, "correct or remove the line")
    if max(map(abs, values)) > _LARGEST:
        expected = f"seconds and pixels, at most {_LARGEST:.0f} of them"
        raise _refused(f"{path}, line {line}", _quoted(row), expected, "correct the units, or remove the line")
    return values


def _quoted(row: list[str]) -> str:
    """The row as it stands in the file, as much of it as a person wants to read."""
    text = ",".join(row)
    return f"'{text}'" if len(text) <= _SHOWN else f"'{text[:_SHOWN]}...'"


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
