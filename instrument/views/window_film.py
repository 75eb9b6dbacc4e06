"""The film of a long recording: the image of each of its windows, one after the other, over the path of the whole run."""

from pathlib import Path
from typing import Any

from instrument.analysis import Windowed
from instrument.views.film import film_writer, refuse_no_film
from instrument.views.images import draw_image
from instrument.views.plots import draw_trajectory
from instrument.views.style import X_COLOUR, new_figure
from protocols import InputError

_HELD = 5
_DPI = 100


def write_window_film(windowed: Windowed, path: str | Path) -> Path:
    """Write a film with a picture for each window that has an image, three a second.

    Args:
        windowed: a run that was analysed in windows.
        path: file to write, .gif or .mp4.

    Raises:
        InputError: no window has an image, or as ``refuse_no_film``.
    """
    path = Path(path)
    refuse_no_film(path)
    if not windowed.images:
        raise InputError(
            saw="a run of whose windows no image was made",
            expected="one image at least",
            remedy="analyse it with images of its windows",
        )
    found = windowed.trajectory
    few = slice(None, None, max(1, len(found) // 2000))  # a line of more points than a screen has looks the same
    top = max(float(one.image.max()) for one in windowed.images)
    figure = new_figure(6.4, 7.2)
    upper, lower = figure.subplots(2, 1, height_ratios=[2.2, 1])
    draw_trajectory(lower, found.time_s[few], found.displacement_px[few], None)
    span: Any = None
    part = path.with_name(f".{path.stem}.part{path.suffix}")
    try:
        with film_writer(path) as writer, writer.saving(figure, str(part), _DPI):
            for one in windowed.images:
                upper.clear()
                first, end = one.window.first, one.window.end
                draw_image(upper, one.image, f"frames {first} to {end - 1}", vmax=top)
                if span is not None:
                    span.remove()
                span = lower.axvspan(found.time_s[first], found.time_s[end - 1], color=X_COLOUR, alpha=0.2)
                for _ in range(_HELD):
                    writer.grab_frame()
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
    return path
