"""The analysis of a recording: path, image and figures of merit."""

from instrument.analysis.analyse import Analysis, OnStep, analyse
from instrument.analysis.compare import Compared, Comparison, compare, compare_images
from instrument.analysis.forming import Stage, forming
from instrument.analysis.merit import Figures, figures_of
from instrument.analysis.stored import analyse_path, background_choice, light_found, recording_to_analyse, store
from instrument.analysis.windows import WINDOW_FRAMES, Windowed, WindowImage, analyse_in_windows

__all__ = [
    "WINDOW_FRAMES",
    "Analysis",
    "Compared",
    "Comparison",
    "Figures",
    "OnStep",
    "Stage",
    "WindowImage",
    "Windowed",
    "analyse",
    "analyse_in_windows",
    "analyse_path",
    "background_choice",
    "compare",
    "compare_images",
    "figures_of",
    "forming",
    "light_found",
    "recording_to_analyse",
    "store",
]
