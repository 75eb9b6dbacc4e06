"""A bench for the RunEngine of bluesky: the stage, and modulator and counter as one detector that flies."""

from instrument.bluesky_devices.audit import KinopixAudit
from instrument.bluesky_devices.detector import KinopixDetector
from instrument.bluesky_devices.documents import recording_of
from instrument.bluesky_devices.plans import record
from instrument.bluesky_devices.stage import KinopixStage
from instrument.bluesky_devices.status import WorkStatus

__all__ = ["KinopixAudit", "KinopixDetector", "KinopixStage", "WorkStatus", "record", "recording_of"]
