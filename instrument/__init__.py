"""The framework: plans, acquisition, tracking, reconstruction, and the bench that composes the devices.

    from instrument import Instrument, Plan, track, reconstruct

    with Instrument.from_toml("bench.toml") as bench:
        recording = bench.run(Plan.from_toml("plan.toml"))
    motion = track(recording)
    image = reconstruct(recording, motion)
"""

from instrument.analysis import Analysis, analyse
from instrument.instrument import Instrument
from instrument.plan import MotionPlan, Plan
from instrument.reconstruction import Reconstruction, reconstruct
from instrument.recording import Recording
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
