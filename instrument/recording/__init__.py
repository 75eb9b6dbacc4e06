"""A recording as a value: what was measured, when, and which frames are valid."""

from instrument.recording.recording import Recording
from instrument.recording.stage_log import COLUMNS as STAGE_COLUMNS
from instrument.recording.stage_log import StageLog
from instrument.recording.timing import TimingReport, Verdict

__all__ = ["STAGE_COLUMNS", "Recording", "StageLog", "TimingReport", "Verdict"]
