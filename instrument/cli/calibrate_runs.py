"""``kinopix calibrate displacement --from`` with several runs: each by itself, on all cores or a cluster, and their mean."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from instrument.cli.several import refuse_failures, told_of

if TYPE_CHECKING:
    from instrument.config import DisplacementSection
    from instrument.series import Cell
    from instrument.workers import Failure, Progress

COLUMNS: Final[dict[str, type]] = {
    "recording": str,
    "outcome": str,
    "why": str,
    "px_per_mm": float,
    "px_per_mm_sigma": float,
    "axis_angle_deg": float,
    "axis_angle_sigma_deg": float,
    "px_per_mm_x": float,
    "px_per_mm_y": float,
    "rms_residual_px": float,
    "image_size": int,
    "superpixel": int,
    "date": str,
}
"""Columns of the table, and their types. ``outcome`` is ``measured``, ``kept`` (it had been before) or ``failed``."""


@dataclass(frozen=True)
class RunsOptions:
    """What can be asked where a calibration is made from several runs."""

    workers: int | None = None
    scheduler: str | None = None
    path_map: Sequence[str] = ()
    tables: Sequence[Path] = ()
    again: bool = False

    @property
    def several(self) -> bool:
        """Whether something is asked for that one run by itself has not."""
        return bool(self.workers or self.scheduler or self.path_map or self.tables or self.again)


@dataclass(frozen=True)
class ByRuns:
    """What several runs say."""

    together: "DisplacementSection"
    """The displacement."""

    failures: "Mapping[Path, Failure]"
    """Why some runs are not in it."""


def runs_in(places: Sequence[Path], options: RunsOptions) -> list[Path]:
    """List the recordings that a command names.

    Args:
        places: recordings, and folders of recordings.
        options: what else was asked for.

    Raises:
        InputError: a folder without recordings, or a table that cannot be written.
    """
    from instrument.series import recordings_in, refuse_table

    for table in options.tables:
        refuse_table(table)
    return recordings_in(places)


def measured_by(recordings: Sequence[Path], options: RunsOptions, calibration: Path) -> "ByRuns":
    """Measure by each run that was not measured before, print the table of all, and give what they say together.

    Args:
        recordings: of the runs.
        options: who does it, and where the table goes.
        calibration: the calibration file. What each run says is kept beside it, in ``<its name>-points``.

    Raises:
        InputError: no run can be measured, or the runs do not agree.
        KinopixError: no run can be measured, by another fault than theirs.
    """
    from instrument.calibration import displacement_of_runs, pooled
    from instrument.series import write_rows
    from instrument.views import ERR, runs_table
    from instrument.workers import PathMap, Where

    with told_of(len(recordings)) as tell:
        done = displacement_of_runs(
            recordings,
            calibration.with_name(f"{calibration.stem}-points"),
            where=Where.of(options.workers, options.scheduler),
            path_map=PathMap.of(options.path_map),
            again=options.again,
            on_run=tell,
        )
    rows = [_row(path, done) for path in recordings]
    for table in options.tables:
        write_rows(rows, COLUMNS, table)
    ERR.print(runs_table(rows))
    if not done.found:
        refuse_failures(done.failures, len(recordings), "measured")
    found = {str(path): done.found[path] for path in recordings if path in done.found}
    return ByRuns(pooled(found), done.failures)


def _row(path: Path, done: "Progress[Path, DisplacementSection]") -> "dict[str, Cell]":
    row: dict[str, Cell] = dict.fromkeys(COLUMNS)
    row["recording"] = str(path)
    section = done.found.get(path)
    if section is None:
        return {**row, "outcome": "failed", "why": done.failures[path].why}
    figures: dict[str, Cell] = {name: getattr(section, name) for name in list(COLUMNS)[3:-1]}
    outcome = "kept" if path in done.kept else "measured"
    return {**row, "outcome": outcome, **figures, "date": section.date.isoformat()}
