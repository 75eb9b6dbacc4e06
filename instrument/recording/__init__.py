"""A recording as a value: what was measured, when, and which frames are valid."""

from instrument.recording.recording import Recording
from instrument.recording.timing import TimingReport, Verdict

__all__ = ["Recording", "TimingReport", "Verdict"]
