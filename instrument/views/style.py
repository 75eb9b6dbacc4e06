# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false
# matplotlib leaves the type of its **kwargs open.
"""One style for all pictures of a recording: colours, letters, and the foot that says what a picture is of."""

from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap
from typing import Final, Literal, TypeAlias

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import findfont, get_font

from instrument.views.terminal import plain

PictureFormat: TypeAlias = Literal["png", "pdf", "svg"]
"""Kinds of pictures, by the ends of their names."""

X_COLOUR: Final = "#0072b2"
"""Colour of everything along x (the Okabe-Ito palette, safe for colour-blind readers)."""

Y_COLOUR: Final = "#d55e00"
"""Colour of everything along y."""

TRUTH_COLOUR: Final = "0.25"
"""Colour of the truth, where it is known."""

WARNING_COLOUR: Final = "#9a3b00"
"""Colour of what is doubtful."""

FOOT_COLOUR: Final = "0.35"
"""Colour of the foot."""

_SMALL: Final = 7.0
_LINE_IN: Final = 0.145
_LETTERS_AN_INCH: Final = 17.0


def new_figure(width_in: float, height_in: float) -> Figure:
    """Give an empty figure that draws without a screen."""
    figure = Figure(figsize=(width_in, height_in), layout="constrained", dpi=120)
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: Path) -> Path:
    """Write the figure as what its name ends with (PNG, PDF or SVG), and return its path.

    Letters stay letters, which can be searched and edited, and the same picture gives the same file.
    """
    with mpl.rc_context({"pdf.fonttype": 42, "svg.fonttype": "none", "svg.hashsalt": "kinopix"}):
        figure.savefig(path)
    return path


def drawable(text: str) -> str:
    """Write out the characters that the pictures' letters do not have: names of files come from anywhere."""
    letters = get_font(findfont("DejaVu Sans"))
    return "".join(c if letters.get_char_index(ord(c)) else ascii(c)[1:-1] for c in plain(text).plain)


def add_foot(figure: Figure, words: str, doubts: Sequence[str] = ()) -> None:
    """Write below a figure what it is of, and what is doubtful about it. Nothing is cut: long lines are broken.

    Args:
        figure: with its panels; they give way.
        words: what it is of.
        doubts: sentences, each of which gives a reason to doubt.
    """
    width, height = (float(inches) for inches in figure.get_size_inches())
    letters = max(20, int(_LETTERS_AN_INCH * (width - 0.2)))
    lines = [(line, FOOT_COLOUR) for line in wrap(drawable(words), letters)]
    warned = [(line, WARNING_COLOUR) for doubt in doubts for line in wrap(drawable(f"! {doubt}"), letters)]
    all_lines = [*warned, *lines]
    foot_in = _LINE_IN * len(all_lines) + 0.08
    figure.set_size_inches(width, height + foot_in)
    share = foot_in / (height + foot_in)
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.set(rect=(0.0, share, 1.0, 1.0 - share))  # type: ignore[call-arg]
    for row, (line, colour) in enumerate(all_lines):
        place = (foot_in - 0.04 - _LINE_IN * row) / (height + foot_in)
        figure.text(0.1 / width, place, line, fontsize=_SMALL, color=colour, va="top", ha="left", parse_math=False)
