"""``kinopix analyse`` with several recordings: each by itself, on all cores or a cluster, and one table of all."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from instrument.cli.options import print_json
from instrument.cli.several import refuse_failures, told_of

if TYPE_CHECKING:
    from instrument.series import Request


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
    from instrument.series import analyse_series, recordings_in, refuse_table, rows_of, write_table
    from instrument.views import OUT, picture_folder, say, series_table, write_pictures
    from instrument.workers import PathMap, Where

    for table in options.tables:
        refuse_table(table)
    recordings = recordings_in(places)
    for folder in (options.results, options.pictures):
        if folder is not None:
            picture_folder(folder)  # asked before the work, not after
    with told_of(len(recordings)) as tell:
        series = analyse_series(
            recordings,
            request,
            where=Where.of(options.workers, options.scheduler),
            path_map=PathMap.of(options.path_map),
            results=options.results,
            scratch=options.scratch,
            pictures=options.pictures,
            draw=write_pictures,
            again=options.again,
            on_recording=tell,
        )
    for table in options.tables:
        write_table(series, table)
    rows = rows_of(series)
    if options.as_json:
        print_json({"recordings": rows})
    else:
        OUT.print(series_table(rows))
        for path in (*series.pictures, *options.tables):
            say(f"written {path}")
    refuse_failures(series.failures, len(series.recordings), "analysed")
