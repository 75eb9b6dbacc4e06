"""Plan to recording: checks before anything moves, the run itself, and the audit of its timing."""

from instrument.acquisition.alignment import AlignedBlock, Aligner
from instrument.acquisition.audit import TimingAudit
from instrument.acquisition.check_report import Check, CheckReport
from instrument.acquisition.checks import check_plan
from instrument.acquisition.devices import Devices
from instrument.acquisition.recorded import check_recording
from instrument.acquisition.run import Host, Outcome, Phase, acquire, prepare
from instrument.recording import TimingReport

__all__ = [
    "AlignedBlock",
    "Aligner",
    "Check",
    "CheckReport",
    "Devices",
    "Host",
    "Outcome",
    "Phase",
    "TimingAudit",
    "TimingReport",
    "acquire",
    "check_plan",
    "check_recording",
    "prepare",
]
