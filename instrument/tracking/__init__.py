"""Displacement from values: frame by frame as in the paper, smoothed over the whole run, or while the run goes on."""

from instrument.choices import TrackingMethod
from instrument.tracking.covariance import PathCovariance
from instrument.tracking.kinematics import MotionFit, Quantity
from instrument.tracking.streaming import StreamingTracker
from instrument.tracking.track import track
from instrument.tracking.trajectory import Trajectory, as_trajectory

__all__ = [
    "MotionFit",
    "PathCovariance",
    "Quantity",
    "StreamingTracker",
    "TrackingMethod",
    "Trajectory",
    "as_trajectory",
    "track",
]
