"""What a person looks at: figures as PNG, tables and progress in the terminal."""

from instrument.views.plots import error_figure, image_figure, save, timing_figure, trajectory_figure
from instrument.views.summary import summary_figure

__all__ = ["error_figure", "image_figure", "save", "summary_figure", "timing_figure", "trajectory_figure"]
