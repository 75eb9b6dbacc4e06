from .analysis import Analysis as Analysis
from .analysis import Figures as Figures
from .analysis import analyse as analyse
from .analysis import analyse_path as analyse_path
from .joint import Refined as Refined
from .joint import refine as refine
from .measurement import Measurement as Measurement
from .plan import MotionPlan as MotionPlan
from .plan import Plan as Plan
from .reconstruction import Reconstruction as Reconstruction
from .reconstruction import Region as Region
from .reconstruction import reconstruct as reconstruct
from .recording import Recording as Recording
from .recording import TimingReport as TimingReport
from .schemes import Scheme as Scheme
from .schemes import scheme_of as scheme_of
from .session import Instrument as Instrument
from .session import Run as Run
from .session import RunAborted as RunAborted
from .session import RunStopped as RunStopped
from .session import simulate as simulate
from .storage import open_recording as open_recording
from .tracking import StreamingTracker as StreamingTracker
from .tracking import Trajectory as Trajectory
from .tracking import track as track

__all__ = [
    "Analysis",
    "Figures",
    "Instrument",
    "Measurement",
    "MotionPlan",
    "Plan",
    "Reconstruction",
    "Recording",
    "Refined",
    "Region",
    "Run",
    "RunAborted",
    "RunStopped",
    "Scheme",
    "StreamingTracker",
    "TimingReport",
    "Trajectory",
    "analyse",
    "analyse_path",
    "open_recording",
    "reconstruct",
    "refine",
    "scheme_of",
    "simulate",
    "track",
]
