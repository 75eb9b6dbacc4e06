"""Displacement from values: frame by frame as in the paper, smoothed over the whole run, or while the run goes on."""

from instrument.choices import TrackingMethod
from instrument.tracking.covariance import PathCovariance
from instrument.tracking.kinematics import MotionFit, Quantity
from instrument.tracking.start import with_start
from instrument.tracking.streaming import StreamingTracker
from instrument.tracking.track import track
from instrument.tracking.trajectory import Trajectory, as_trajectory
from instrument.tracking.windows import JoinedPath, Window, windows_of

__all__ = [
    "JoinedPath",
    "MotionFit",
    "PathCovariance",
    "Quantity",
    "StreamingTracker",
    "TrackingMethod",
    "Trajectory",
    "Window",
    "as_trajectory",
    "track",
    "windows_of",
    "with_start",
]
