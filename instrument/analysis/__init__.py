"""The analysis of a recording: path, image and figures of merit."""

from instrument.analysis.analyse import Analysis, OnStep, analyse
from instrument.analysis.compare import Compared, Comparison, compare, compare_images
from instrument.analysis.merit import Figures, figures_of
from instrument.analysis.stored import analyse_path, background_choice, light_found, recording_to_analyse, store

__all__ = [
    "Analysis",
    "Compared",
    "Comparison",
    "Figures",
    "OnStep",
    "analyse",
    "analyse_path",
    "background_choice",
    "compare",
    "compare_images",
    "figures_of",
    "light_found",
    "recording_to_analyse",
    "store",
]
