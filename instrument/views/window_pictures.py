"""The pictures of a run that was analysed in windows."""

from pathlib import Path
from typing import Final

from matplotlib.figure import Figure

from instrument.analysis import Windowed, WindowImage
from instrument.views.images import draw_image
from instrument.views.pictures import foot_of_file, picture_folder
from instrument.views.plots import error_figure, trajectory_figure
from instrument.views.style import PictureFormat, add_foot, new_figure, save

_MOST_POINTS: Final = 4000
"""Points of a line: one of more looks the same."""

_MOST_IMAGES: Final = 12
"""Images side by side, in time from the first to the last."""

_COLUMNS: Final = 4


def write_window_pictures(windowed: Windowed, folder: Path, stem: str = "", kind: PictureFormat = "png") -> list[Path]:
    """Draw the path of the whole run, its error (where the truth is known), the images of windows, and what stands still.

    Args:
        windowed: a run that was analysed in windows.
        folder: folder for the pictures, which is made if it is missing; pictures that exist are replaced.
        stem: beginning of the file names; empty for none.
        kind: PNG to look at; PDF or SVG to print.

    Returns:
        The files written, the path first.
    """
    picture_folder(folder)
    foot, doubts = foot_of_file(windowed.path), list(windowed.figures.doubts)
    drawn: list[Path] = []
    for name, figure in _figures(windowed).items():
        add_foot(figure, foot, doubts)
        drawn.append(save(figure, folder / f"{stem}-{name}.{kind}" if stem else folder / f"{name}.{kind}"))
    return drawn


def _figures(windowed: Windowed) -> dict[str, Figure]:
    path, truth_px = windowed.trajectory, windowed.truth_px
    scale = None if path.scale is None else path.scale.px_per_mm
    few = slice(None, None, max(1, len(path) // _MOST_POINTS))
    time_s, place_px, sigma_px = path.time_s[few], path.displacement_px[few], path.sigma_px[few]
    true_px = None if truth_px is None else truth_px[few]
    figures = {"trajectory": trajectory_figure(time_s, place_px, true_px, px_per_mm=scale, sigma_px=sigma_px)}
    if true_px is not None:
        figures["error"] = error_figure(time_s, place_px - true_px, sigma_px)
    if windowed.images:
        figures["windows"] = _images(windowed.images, scale)
    still = next((one.still for one in windowed.images if one.still is not None), None)
    if still is not None:
        figures["background"] = new_figure(4.1, 3.9)
        draw_image(figures["background"].subplots(), still, "what stands still", px_per_mm=scale)
    return figures


def _images(images: tuple[WindowImage, ...], px_per_mm: float | None) -> Figure:
    """All images on one grey scale; of many, some from the first to the last."""
    count = min(len(images), _MOST_IMAGES)
    shown = [images[round(k * (len(images) - 1) / max(1, count - 1))] for k in range(count)]
    columns = min(_COLUMNS, len(shown))
    rows = -(-len(shown) // columns)
    figure = new_figure(3.4 * columns, 3.5 * rows)
    top = max(float(one.image.max()) for one in shown)
    for number, one in enumerate(shown):
        axes = figure.add_subplot(rows, columns, number + 1)
        title = f"frames {one.window.first} to {one.window.end - 1}"
        draw_image(axes, one.image, title, vmax=top, px_per_mm=px_per_mm, bar=number == len(shown) - 1)
    return figure
