"""The framework: plans, acquisition, tracking, reconstruction, and the bench that composes the devices.

A lab script needs `Instrument` and `Plan` to record, `track` and `reconstruct` to analyse.
"""

from instrument.analysis import Analysis, analyse
from instrument.plan import MotionPlan, Plan
from instrument.reconstruction import Reconstruction, reconstruct
from instrument.recording import Recording
from instrument.session import Instrument
from instrument.storage import open_recording
from instrument.tracking import Trajectory, track

__all__ = [
    "Analysis",
    "Instrument",
    "MotionPlan",
    "Plan",
    "Reconstruction",
    "Recording",
    "Trajectory",
    "analyse",
    "open_recording",
    "reconstruct",
    "track",
]
