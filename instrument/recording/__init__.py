"""A recording as a value: what was measured, when, and which frames to trust."""

from instrument.recording.timing import TimingReport
from instrument.recording.recording import Recording

__all__ = ["Recording", "TimingReport"]
