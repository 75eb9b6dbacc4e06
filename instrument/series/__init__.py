"""Many recordings analysed: on this computer or a cluster, gone on with after a kill, and summed up in one table."""

from instrument.series.analyse_series import OnRecording, Series, analyse_series
from instrument.series.one_recording import Draw, Outcome
from instrument.series.recordings import recordings_in
from instrument.series.request import Request
from instrument.series.table import COLUMNS, Cell, refuse_table, rows_of, write_rows, write_table

__all__ = [
    "COLUMNS",
    "Cell",
    "Draw",
    "OnRecording",
    "Outcome",
    "Request",
    "Series",
    "analyse_series",
    "recordings_in",
    "refuse_table",
    "rows_of",
    "write_rows",
    "write_table",
]
