"""The analysis of a recording: path, image and figures of merit."""

from instrument.analysis.analyse import Analysis, OnStep, analyse
from instrument.analysis.forming import Stage, forming
from instrument.analysis.merit import Figures, figures_of
from instrument.analysis.stored import analyse_path, background_choice, light_found, recording_to_analyse, store

__all__ = [
    "Analysis",
    "Figures",
    "OnStep",
    "Stage",
    "analyse",
    "analyse_path",
    "background_choice",
    "figures_of",
    "forming",
    "light_found",
    "recording_to_analyse",
    "store",
]
