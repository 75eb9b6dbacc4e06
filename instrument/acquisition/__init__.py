"""Plan to recording: checks before anything moves, the run itself, and the audit of its timing."""

from instrument.acquisition.alignment import AlignedBlock, Aligner
from instrument.acquisition.audit import TimingAudit
from instrument.acquisition.checks import Check, CheckReport, check_plan
from instrument.acquisition.run import Devices, Outcome, Sink, acquire, prepare
from instrument.recording import TimingReport

__all__ = [
    "AlignedBlock",
    "Aligner",
    "Check",
    "CheckReport",
    "Devices",
    "Outcome",
    "Sink",
    "TimingAudit",
    "TimingReport",
    "acquire",
    "check_plan",
    "prepare",
]
