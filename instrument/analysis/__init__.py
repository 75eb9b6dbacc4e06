"""The whole way from a recording to its figures."""

from instrument.analysis.analyse import Analysis, OnStep, Tracking, analyse
from instrument.analysis.merit import Figures, figures_of

__all__ = ["Analysis", "Figures", "OnStep", "Tracking", "analyse", "figures_of"]
