from .alignment import alignment_figure as alignment_figure
from .blocks import white_of as white_of
from .calibration_table import displacement_figures as displacement_figures
from .calibration_table import displacement_rows as displacement_rows
from .calibration_table import displacement_table as displacement_table
from .calibration_table import runs_table as runs_table
from .film import refuse_no_film as refuse_no_film
from .film import write_film as write_film
from .images import compared_figure as compared_figure
from .images import image_figure as image_figure
from .live import LiveView as LiveView
from .pictures import picture_folder as picture_folder
from .pictures import write_pictures as write_pictures
from .plots import error_figure as error_figure
from .plots import timing_figure as timing_figure
from .plots import trajectory_figure as trajectory_figure
from .recording_table import about_in_words as about_in_words
from .recording_table import plan_in_words as plan_in_words
from .recording_table import recording_table as recording_table
from .run_log import log_events as log_events
from .series_table import series_table as series_table
from .study_figures import write_study_pictures as write_study_pictures
from .study_tables import claims_table as claims_table
from .study_tables import study_index as study_index
from .study_tables import study_page as study_page
from .study_tables import study_tables as study_tables
from .study_tables import write_csv as write_csv
from .style import PictureFormat as PictureFormat
from .style import save as save
from .summary import summary_figure as summary_figure
from .terminal import ERR as ERR
from .terminal import LOG as LOG
from .terminal import OUT as OUT
from .terminal import check_table as check_table
from .terminal import figures_table as figures_table
from .terminal import forget_warnings as forget_warnings
from .terminal import plain as plain
from .terminal import progress as progress
from .terminal import say as say
from .terminal import show_error as show_error
from .terminal import timing_table as timing_table
from .terminal import warn as warn
from .terminal import warned as warned
from .trace import Trace as Trace
from .window_film import write_window_film as write_window_film
from .window_pictures import write_window_pictures as write_window_pictures

__all__ = [
    "ERR",
    "LOG",
    "OUT",
    "LiveView",
    "PictureFormat",
    "Trace",
    "about_in_words",
    "alignment_figure",
    "check_table",
    "claims_table",
    "compared_figure",
    "displacement_figures",
    "displacement_rows",
    "displacement_table",
    "error_figure",
    "figures_table",
    "forget_warnings",
    "image_figure",
    "log_events",
    "picture_folder",
    "plain",
    "plan_in_words",
    "progress",
    "recording_table",
    "refuse_no_film",
    "runs_table",
    "save",
    "say",
    "series_table",
    "show_error",
    "study_index",
    "study_page",
    "study_tables",
    "summary_figure",
    "timing_figure",
    "timing_table",
    "trajectory_figure",
    "warn",
    "warned",
    "white_of",
    "write_csv",
    "write_film",
    "write_pictures",
    "write_study_pictures",
    "write_window_film",
    "write_window_pictures",
]
