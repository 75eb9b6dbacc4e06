# pyright: reportUnknownMemberType=false
# matplotlib leaves the type of its **kwargs open.
"""The one picture that a newcomer sees first."""

from matplotlib.figure import Figure

from instrument.views.figures import draw_image, draw_trajectory, new_figure
from protocols import Floats


def summary_figure(
    *,
    ignored: Floats,
    image: Floats,
    truth: Floats | None,
    time_s: Floats,
    displacement_px: Floats,
    truth_px: Floats | None,
    caption: str,
) -> Figure:
    """Show what the same light gives without and with the motion taken back, and the motion itself.

    Args:
        ignored: ``(m, m)``: image reconstructed as if the object had stood still.
        image: ``(m, m)``: image reconstructed with the measured motion.
        truth: ``(m, m)`` or None.
        time_s: ``(frames,)``.
        displacement_px: ``(frames, 2)``.
        truth_px: likewise, or None.
        caption: one line of figures under the title.
    """
    panels = 2 if truth is None else 3
    figure = new_figure(3.9 * panels, 7.4)
    grid = figure.add_gridspec(2, panels, height_ratios=[1.15, 1])
    draw_image(figure.add_subplot(grid[0, 0]), ignored, "motion ignored")
    draw_image(figure.add_subplot(grid[0, 1]), image, "motion measured and taken back")
    if truth is not None:
        draw_image(figure.add_subplot(grid[0, 2]), truth, "the object, at frame 0")
    draw_trajectory(figure.add_subplot(grid[1, :]), time_s, displacement_px, truth_px)
    figure.suptitle(f"One detector, one object that never stood still\n{caption}", fontsize=11)
    return figure
