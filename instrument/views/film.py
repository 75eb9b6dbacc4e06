# pyright: reportUnknownMemberType=false
# matplotlib leaves the type of its **kwargs open.
"""The film of a run, after the paper's Visualization 1: the object moves, and its image forms from more and more frames."""

import importlib
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.ndimage import shift

from instrument.analysis import Analysis, Stage, forming
from instrument.reconstruction import Reconstruction
from instrument.tracking import Trajectory
from instrument.views.style import X_COLOUR, Y_COLOUR, new_figure
from protocols import Floats, InputError

_KINDS: Final = (".gif", ".mp4")
_PICTURES_A_SECOND: Final = 15
_HELD: Final = 15
"""Times that the last picture is shown: a second."""

_DPI: Final = 100
"""With 9.6 x 5.8 inches even numbers of pixels, as MP4 needs them."""


def refuse_no_film(path: Path) -> None:
    """Refuse a film that cannot be written, before any work.

    Raises:
        InputError: the name is neither a GIF nor an MP4, or MP4 is asked for and its library is not installed.
    """
    if path.suffix.lower() not in _KINDS:
        raise InputError(saw=f"the film {path}", expected="a name that ends in .mp4 or .gif", remedy="correct the name")
    if path.suffix.lower() == ".mp4":
        _ffmpeg()


def write_film(
    analysis: Analysis, path: Path, *, pictures: int = 60, on_picture: Callable[[int, int], object] | None = None
) -> Path:
    """Write the film of an analysed run.

    Args:
        analysis: the run, with path and image.
        path: file to write, .gif or .mp4.
        pictures: number of different pictures; 15 are shown a second.
        on_picture: function that is called with the number of pictures done, and of all.

    Raises:
        InputError: as ``refuse_no_film``, or the run has no path or no image.
    """
    refuse_no_film(path)
    found = analysis.trajectory
    stages = forming(analysis, pictures)
    first = next(stages)  # what has no film is refused before a file is made
    image = analysis.reconstruction
    if found is None or image is None:
        return path
    picture = _Picture(image, found)
    part = path.with_name(f".{path.stem}.part{path.suffix}")
    try:
        with film_writer(path) as writer, writer.saving(picture.figure, str(part), _DPI):
            for done, stage in enumerate(_with_first(first, stages), start=1):
                picture.show(stage)
                for _ in range(_HELD if stage.frames == len(found) else 1):
                    writer.grab_frame()
                if on_picture is not None:
                    on_picture(done, pictures)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
    return path


class _Picture:
    """The picture of the film, which changes from stage to stage."""

    def __init__(self, found_image: Reconstruction, found: Trajectory) -> None:
        """Draw what stays."""
        cells, field = found_image.grid, found_image.field
        image, still = found_image.image, _still(found_image)
        self._image, self._shift_cells, self._still = image, found.displacement_px * cells, still
        self._field = tuple(slice(cells * first, cells * (first + field.width)) for first in (field.top, field.left))
        self._place_px, self._time_s = found.displacement_px, found.time_s
        place_px, time_s = self._place_px, self._time_s
        self.figure: Figure = new_figure(9.6, 5.8)
        grid = self.figure.add_gridspec(2, 2, height_ratios=[2.2, 1])
        self._top = float(max(image.max(), 0 if still is None else still.max())) or 1.0
        self._moving = self._panel(grid[0, 0], "the object in the field", image[self._field])
        self._forming = self._panel(grid[0, 1], "its image", image)
        axes = self.figure.add_subplot(grid[1, :])
        axes.set_xlim(0, float(time_s[-1]))
        margin = 0.05 * max(1.0, float(np.ptp(place_px)))
        axes.set_ylim(float(place_px.min()) - margin, float(place_px.max()) + margin)
        axes.set_xlabel("time, s")
        axes.set_ylabel("displacement, px")
        self._lines = [
            axes.plot([], [], color=colour, linewidth=width, label=name)[0]
            for name, colour, width in (("x", X_COLOUR, 5.0), ("y", Y_COLOUR, 2.0))
        ]
        axes.legend(loc="upper left", frameon=False)

    def _panel(self, place: Any, title: str, image: Floats) -> Any:
        axes: Axes = self.figure.add_subplot(place)
        axes.set_title(title)
        axes.set_xticks([])
        axes.set_yticks([])
        return axes.imshow(np.zeros_like(image), cmap="gray", vmin=0.0, vmax=self._top, interpolation="nearest")

    def show(self, stage: Stage) -> None:
        """Show the run after the stage's frames."""
        now = stage.frames - 1
        across, down = self._shift_cells[now].tolist()
        moved = np.asarray(shift(self._image, (down, across), order=1), np.float64)[self._field]
        self._moving.set_data(moved if self._still is None else moved + self._still)
        self._forming.set_data(stage.image)
        self._forming.axes.set_title(f"its image, from {stage.frames} of {len(self._time_s)} frames")
        for axis, line in enumerate(self._lines):
            line.set_data(self._time_s[: stage.frames], self._place_px[: stage.frames, axis])


def _still(found: Reconstruction) -> Floats | None:
    """Give what stands still, on the pixels of the object's image."""
    if found.still is None:
        return None
    return np.asarray(np.kron(found.still, np.ones((found.grid, found.grid))), np.float64)


def _with_first(first: Stage, others: Generator[Stage]) -> Generator[Stage]:
    yield first
    yield from others


@contextmanager
def film_writer(path: Path) -> Generator[Any]:
    """Give matplotlib's writer for the kind of file, 15 pictures a second."""
    if path.suffix.lower() == ".gif":
        yield PillowWriter(fps=_PICTURES_A_SECOND)
        return
    with mpl.rc_context({"animation.ffmpeg_path": _ffmpeg()}):
        yield FFMpegWriter(fps=_PICTURES_A_SECOND, codec="libx264", extra_args=["-pix_fmt", "yuv420p"])


def _ffmpeg() -> str:
    """Give the path of ffmpeg's program, which the library imageio-ffmpeg brings."""
    try:
        library = importlib.import_module("imageio_ffmpeg")
    except ImportError as error:
        raise InputError(
            saw="no library imageio-ffmpeg, which writes MP4",
            expected="Kinopix with what films need",
            remedy="pip install 'kinopix[film]', or name a .gif, which needs nothing more",
        ) from error
    program: str = library.get_ffmpeg_exe()
    return program
