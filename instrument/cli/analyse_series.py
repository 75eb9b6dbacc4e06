"""``kinopix analyse`` with several recordings: each by itself, on all cores or a cluster, and one table of all."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from instrument.cli.options import print_json

if TYPE_CHECKING:
    from instrument.series import Request, Series
    from instrument.workers import Where


@dataclass(frozen=True)
class SeriesOptions:
    """What can be asked of a series beyond how each recording is analysed."""

    workers: int | None = None
    scheduler: str | None = None
    path_map: Sequence[str] = ()
    scratch: Path | None = None
    results: Path | None = None
    pictures: Path | None = None
    tables: Sequence[Path] = ()
    again: bool = False
    as_json: bool = False

    @property
    def several(self) -> bool:
        """Whether something is asked for that one recording by itself has not."""
        return bool(self.tables or self.again or self.workers or self.scheduler or self.path_map or self.scratch)


def analyse_several(places: list[Path], request: "Request", options: SeriesOptions) -> None:
    """Analyse recordings, print the table of all, and name those that fail at the end.

    Raises:
        InputError: a place without recordings; or some recordings fail, all of them by a wrong input.
        KinopixError: some recordings fail.
    """
    from instrument.series import recordings_in, refuse_table, rows_of, write_table
    from instrument.views import OUT, picture_folder, say, series_table
    from instrument.workers import Where

    for table in options.tables:
        refuse_table(table)
    recordings = recordings_in(places)
    for folder in (options.results, options.pictures):
        if folder is not None:
            picture_folder(folder)  # asked before the work, not after
    series = _carried_out(recordings, request, options, Where.of(options.workers, options.scheduler))
    for table in options.tables:
        write_table(series, table)
    rows = rows_of(series)
    if options.as_json:
        print_json({"recordings": rows})
    else:
        OUT.print(series_table(rows))
        for path in (*series.pictures, *options.tables):
            say(f"written {path}")
    _refuse_failures(series)


def _carried_out(recordings: list[Path], request: "Request", options: SeriesOptions, where: "Where") -> "Series":
    """Analyse under a progress bar, and say what is kept if somebody interrupts it."""
    from instrument.series import analyse_series
    from instrument.views import progress, write_pictures
    from instrument.workers import PathMap

    counts = [0, len(recordings)]
    with progress() as bars:
        task = bars.add_task("recordings", total=len(recordings))

        def tell(path: Path, done: int, total: int) -> None:
            counts[:] = done, total
            bars.update(task, description=path.name, completed=done, total=total)

        try:
            return analyse_series(
                recordings,
                request,
                where=where,
                path_map=PathMap.of(options.path_map),
                results=options.results,
                scratch=options.scratch,
                pictures=options.pictures,
                draw=write_pictures,
                again=options.again,
                on_recording=tell,
            )
        except KeyboardInterrupt as interrupt:
            interrupt.add_note(
                f"{counts[0]} of {counts[1]} recordings are done, and the same command goes on from there"
            )
            raise


def _refuse_failures(series: "Series") -> None:
    from protocols import InputError, KinopixError

    if not series.failures:
        return
    wrong_inputs = all(failure.exit_code == InputError.exit_code for failure in series.failures.values())
    error = (InputError if wrong_inputs else KinopixError)(
        saw=f"{len(series.failures)} of {len(series.recordings)} recordings that could not be analysed",
        expected="all analysed; the others are",
        remedy="look at the reasons below, then give the same command: it does what is missing",
    )
    for path, failure in series.failures.items():
        error.add_note(f"{path}: {failure.why}")
    raise error
