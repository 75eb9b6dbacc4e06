"""All runs of a series in one table: a row a recording, a column a figure with its unit in the name; as CSV or Parquet."""

import csv
import os
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, Final, TypeAlias

from instrument.series.analyse_series import Series
from instrument.storage import RecordingInfo
from protocols import InputError

Cell: TypeAlias = str | float | int | None
"""What a table holds; None where there is no such figure."""

_MOTION: Final = {
    f"{figure}{suffix}_{unit}{per}": (f"motion_{unit}.{figure}.{part}", float)
    for unit in ("mm", "px")
    for figure, per in (("travel", ""), ("speed", "_s"), ("acceleration", "_s2"))
    for suffix, part in (("", "value"), ("_low", "low"), ("_high", "high"))
}

_FIGURES: Final[dict[str, tuple[str, type]]] = {
    "frames": ("frames", int),
    "frames_masked": ("frames_masked", int),
    "travel_x_px": ("travel_px.0", float),
    "travel_y_px": ("travel_px.1", float),
    "sigma_px": ("sigma_px", float),
    "start_x_px": ("start_px.0", float),
    "start_y_px": ("start_px.1", float),
    "turn_deg": ("turn_deg", float),
    "turn_sigma_deg": ("turn_sigma_deg", float),
    **_MOTION,
    "misfit": ("misfit", float),
    "light_change": ("light_change", float),
    "leak": ("light.leak.value", float),
    "edge_loss": ("light.edge_loss.value", float),
    "background_share": ("background_share", float),
    "displacement_mse_px2": ("displacement_mse_px2", float),
    "displacement_mse_offset_free_px2": ("displacement_mse_offset_free_px2", float),
    "psnr_db": ("psnr_db", float),
    "ssim_global": ("ssim_global", float),
    "ssim_local": ("ssim_local", float),
    "image_grid": ("grid", int),
    "analysis_s": ("analysis_s", float),
}
"""Columns of figures: where each stands in the table of an analysis, and what it is."""

_PLAN: Final[dict[str, tuple[str, type]]] = {
    "scheme": ("scheme.name", str),
    "image_size": ("image_size", int),
    "pattern_rate_hz": ("pattern_rate_hz", float),
    "start_mm": ("motion.start_mm", float),
    "velocity_mm_s": ("motion.velocity_mm_s", float),
    "acceleration_mm_s2": ("motion.acceleration_mm_s2", float),
}

COLUMNS: Final[dict[str, type]] = {
    "recording": str,
    "outcome": str,
    "why": str,
    "start_time": str,
    **{name: kind for name, (_, kind) in _PLAN.items()},
    **{name: kind for name, (_, kind) in _FIGURES.items()},
    "doubts": str,
    "analysed": str,
    "version": str,
}
"""Every column and its type. ``outcome`` is ``analysed``, ``kept`` (it had been before) or ``failed``, and ``why`` says why."""


def rows_of(series: Series) -> list[dict[str, Cell]]:
    """Give the row of each recording, in the order of the series."""
    return [_row(series, path) for path in series.recordings]


def refuse_table(path: str | Path) -> None:
    """Make sure that a table can be written, before the work.

    Raises:
        InputError: its name says no kind of table, its folder is not there, or a library is missing.
    """
    path = Path(path)
    if path.suffix not in _WRITERS:
        raise InputError(saw=f"the table {path}", expected="a name that ends in .csv or .parquet", remedy="name it so")
    if not path.absolute().parent.is_dir() or path.is_dir():
        raise InputError(saw=f"no place for a table at {path}", expected="an existing folder", remedy="make it first")
    if path.suffix == ".parquet":
        _parquet()


def write_table(series: Series, path: str | Path) -> None:
    """Write the table of a series; a table that is there is replaced, by a whole one.

    Raises:
        InputError: as ``refuse_table``.
    """
    write_rows(rows_of(series), COLUMNS, path)


def write_rows(rows: Sequence[Mapping[str, Cell]], columns: Mapping[str, type], path: str | Path) -> None:
    """Write a table of recordings; one that is there is replaced, by a whole one.

    Args:
        rows: what each recording has in the columns.
        columns: each column, and its type: ``str``, ``int`` or ``float``.
        path: ``.csv`` or ``.parquet``.

    Raises:
        InputError: as ``refuse_table``.
    """
    path = Path(path)
    refuse_table(path)
    with _replaced(path) as part:
        _WRITERS[path.suffix](rows, columns, part)


def _row(series: Series, path: Path) -> dict[str, Cell]:
    row: dict[str, Cell] = dict.fromkeys(COLUMNS)
    row["recording"] = str(path)
    info = series.found.get(path)
    if info is None or info.analysis is None:
        return {**row, "outcome": "failed", "why": series.failures[path].why}
    return {**row, "outcome": "kept" if path in series.kept else "analysed", **_known(info, info.analysis.table)} | {
        "analysed": info.analysis.date,
        "version": info.analysis.version,
    }


def _known(info: RecordingInfo, figures: Mapping[str, Any]) -> dict[str, Cell]:
    plan = {} if info.plan is None else info.plan.model_dump(mode="json")
    return {
        "start_time": info.start_time,
        **{name: _typed(_at(plan, where), kind) for name, (where, kind) in _PLAN.items()},
        **{name: _typed(_at(figures, where), kind) for name, (where, kind) in _FIGURES.items()},
        "doubts": " | ".join(figures.get("doubts") or ()),
    }


def _at(tree: Any, where: str) -> Any:
    """Give what stands at a place such as ``motion_mm.speed.value``; None where there is no such place."""
    for name in where.split("."):
        try:
            tree = tree[int(name) if name.isdigit() else name]
        except (KeyError, IndexError, TypeError):
            return None
    return tree


def _typed(value: Any, kind: type) -> Cell:
    return None if value is None else kind(value)


def _write_csv(rows: Sequence[Mapping[str, Cell]], columns: Mapping[str, type], path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(columns))
        writer.writeheader()
        writer.writerows(rows)


def _write_parquet(rows: Sequence[Mapping[str, Cell]], columns: Mapping[str, type], path: Path) -> None:
    arrow = _parquet()
    kinds = {str: arrow.string(), float: arrow.float64(), int: arrow.int64()}
    schema = arrow.schema([(name, kinds[kind]) for name, kind in columns.items()])
    arrow.parquet.write_table(arrow.Table.from_pylist(list(map(dict, rows)), schema=schema), path)


_WRITERS: Final = {".csv": _write_csv, ".parquet": _write_parquet}


def _parquet() -> Any:
    try:
        arrow = import_module("pyarrow")
        import_module("pyarrow.parquet")
    except ImportError as error:
        raise InputError(
            saw=f"a table as Parquet without the library that writes it ({error})",
            expected="the library pyarrow",
            remedy="install kinopix[cluster], or name a table that ends in .csv",
        ) from error
    return arrow


@contextmanager
def _replaced(path: Path) -> Generator[Path]:
    """Give another name beside ``path`` to write to, which takes its place at the end."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
