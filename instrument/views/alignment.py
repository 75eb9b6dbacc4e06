# pyright: reportUnknownMemberType=false
# matplotlib leaves the type of its **kwargs open.
"""The picture by which a person judges the alignment of a bench."""

import numpy as np
from matplotlib.figure import Figure

from instrument.calibration import AlignmentResult, upright
from instrument.views.images import draw_image
from instrument.views.style import X_COLOUR, Y_COLOUR, new_figure

_ARROW = 0.3


def alignment_figure(result: AlignmentResult) -> Figure:
    """Show the image as it lies, with the target's outline and the stage's axis in it, beside the same turned upright.

    Args:
        result: of ``calibrate_alignment``.
    """
    section, image = result.section, result.image
    size = len(image)
    figure = new_figure(9.0, 4.9)
    lies, stands = figure.subplots(1, 2)
    draw_image(lies, np.maximum(image, 0.0), f"as it lies: {section.orientation}, wiring {section.wiring}")
    field = np.zeros((size, size))
    height, width = result.match.template.shape
    column, row = (int(place) for place in result.match.corner_px)
    rows = slice(max(0, row), max(0, min(size, row + height)))
    columns = slice(max(0, column), max(0, min(size, column + width)))
    field[rows, columns] = result.match.template[
        rows.start - row : rows.stop - row, columns.start - column : columns.stop - column
    ]
    lies.contour(field, levels=[0.5], colors=[Y_COLOUR], linewidths=1.0)
    draw_image(stands, np.maximum(upright(image, section.orientation), 0.0), "turned upright: is this the object?")
    for axes, angle_deg in (
        (lies, None if section.axis_angle_deg is None else section.axis_angle_deg.value),
        (stands, section.axis_angle_upright_deg),
    ):
        if angle_deg is not None:
            middle, length, angle = size / 2, _ARROW * size, np.radians(angle_deg)
            tip = (middle + length * float(np.cos(angle)), middle + length * float(np.sin(angle)))
            arrow = {"arrowstyle": "->", "color": X_COLOUR, "linewidth": 2.0}
            axes.annotate("", xy=tip, xytext=(middle, middle), arrowprops=arrow)
            axes.set_xlabel(f"arrow: positive travel, {angle_deg:.1f} degrees from right towards down")
    figure.suptitle(result.verdict[0])
    return figure
