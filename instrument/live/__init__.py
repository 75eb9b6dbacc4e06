"""Motion and image while the run goes on, without delaying the recording."""

from instrument.live.analysis import LiveAnalysis
from instrument.live.imager import ProgressiveImager
from instrument.live.line import LiveCounters, LiveLine, LiveUpdate

__all__ = ["LiveAnalysis", "LiveCounters", "LiveLine", "LiveUpdate", "ProgressiveImager"]
