"""Motion and image while the run goes on, beside the recording and never in its way."""

from instrument.live.analysis import LiveAnalysis
from instrument.live.imager import ProgressiveImager
from instrument.live.line import LiveCounters, LiveLine, LiveUpdate

__all__ = ["LiveAnalysis", "LiveCounters", "LiveLine", "LiveUpdate", "ProgressiveImager"]
