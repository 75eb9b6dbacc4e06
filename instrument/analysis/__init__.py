"""What needs motion and image at once: joint refinement, figures of merit, and the whole way from recording to figures."""

from instrument.analysis.figures import Figures, figures_of
from instrument.analysis.joint import Refined, refine
from instrument.analysis.pipeline import Analysis, Tracking, analyse

__all__ = ["Analysis", "Figures", "Refined", "Tracking", "analyse", "figures_of", "refine"]
