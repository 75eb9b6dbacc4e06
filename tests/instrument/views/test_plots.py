# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false
# matplotlib leaves much of its types open.
"""What is drawn: the numbers in the lines, bands, images and bars, read back from the figure."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from PIL import Image

from instrument.analysis import Analysis, analyse
from instrument.recording import Recording
from instrument.views import picture_folder, write_pictures
from instrument.views.plots import (
    X_COLOUR,
    Y_COLOUR,
    draw_image,
    error_figure,
    image_figure,
    new_figure,
    timing_figure,
    trajectory_figure,
)
from instrument.views.summary import summary_figure
from protocols import Floats, InputError
from tests.support.objects import letter
from tests.support.plans import plan_of
from tests.support.simulation import simulate

TIME_S = np.array([0.1, 0.2, 0.3])
PATH_PX = np.array([[0.0, 0.0], [1.0, -1.0], [2.0, -3.0]])


def lines(axes: Axes) -> dict[str, list[float]]:
    return {str(line.get_label()): np.asarray(line.get_ydata()).tolist() for line in axes.get_lines()}


def bars(axes: Axes) -> list[Rectangle]:
    return [patch for patch in axes.patches if isinstance(patch, Rectangle)]


def test_an_image_is_grey_from_black_to_its_brightest_pixel() -> None:
    axes = new_figure(2, 2).subplots()
    draw_image(axes, np.array([[0.0, 0.5], [0.25, 2.0]]), "half")
    (drawn,) = axes.get_images()
    assert drawn.get_clim() == (0.0, 2.0)
    assert drawn.get_cmap().name == "gray"
    assert drawn.origin == "upper", "row = y down"
    assert axes.get_title() == "half"


@pytest.mark.parametrize(("vmax", "top"), [(None, 1.0), (3.0, 3.0)])
def test_a_dark_image_is_black(vmax: float | None, top: float) -> None:
    axes = new_figure(2, 2).subplots()
    draw_image(axes, np.zeros((2, 2)), "dark", vmax=vmax)
    assert axes.get_images()[0].get_clim() == (0.0, top)


def test_a_path_is_drawn_along_x_and_y_with_the_truth_over_it() -> None:
    (axes,) = trajectory_figure(TIME_S, PATH_PX, PATH_PX + 0.5).axes
    drawn = lines(axes)
    assert drawn["x measured"] == [0, 1, 2]
    assert drawn["y measured"] == [0, -1, -3]
    assert drawn["truth"] == [0.5, 1.5, 2.5]
    assert [np.asarray(line.get_ydata()).tolist() for line in axes.get_lines()][3] == [0.5, -0.5, -2.5]
    assert [line.get_linestyle() for line in axes.get_lines()] == ["-", "-", "--", "--"]
    assert [to_hex(line.get_color()) for line in axes.get_lines()[:2]] == [X_COLOUR, Y_COLOUR]
    assert axes.get_lines()[0].get_linewidth() > axes.get_lines()[1].get_linewidth(), "both are seen on the diagonal"


def test_without_a_truth_there_is_none_in_the_picture() -> None:
    (axes,) = trajectory_figure(TIME_S, PATH_PX, None).axes
    assert list(lines(axes)) == ["x measured", "y measured"]
    assert len(image_figure(np.eye(4), None).axes) == 1
    assert [axes.get_title() for axes in image_figure(np.eye(4), np.eye(4)).axes] == [
        "reconstructed, at frame 0",
        "truth",
    ]


def test_the_error_lies_in_a_band_of_two_standard_deviations() -> None:
    sigma_px = np.array([[0.0, 0.0], [0.5, 1.0], [0.25, 2.0]])
    figure = error_figure(TIME_S, PATH_PX, sigma_px)
    for axes, column in zip(figure.axes, (0, 1), strict=True):
        (band,) = axes.collections
        points = np.asarray(band.get_paths()[0].vertices, np.float64)
        assert np.max(points[:, 1]) == 2 * sigma_px[:, column].max()
        assert np.min(points[:, 1]) == -2 * sigma_px[:, column].max()
        assert lines(axes)[f"error in {'xy'[column]}"] == PATH_PX[:, column].tolist()
    assert not any(axes.collections for axes in error_figure(TIME_S, PATH_PX, None).axes)


def test_the_timing_counts_steps_by_their_distance_from_the_picture_time() -> None:
    """Steps of 50.00, 50.02, 49.98 us and one over a missing edge, which is no step."""
    edges_us = np.array([[0.0, 50.0, 100.02], [150.0, np.nan, 250.0]])
    (axes,) = timing_figure(edges_us * 1e-6, 50e-6).axes
    drawn = bars(axes)
    assert sum(bar.get_height() for bar in drawn) == 3
    assert len(drawn) == 80
    assert drawn[0].get_x() == pytest.approx(-0.02)
    assert drawn[-1].get_x() + drawn[-1].get_width() == pytest.approx(0.02)
    assert axes.get_xlabel() == "sync period minus 50 us, us"


def test_a_perfect_clock_is_drawn_within_ten_nanoseconds() -> None:
    (axes,) = timing_figure(np.arange(8.0) * 50e-6, 50e-6).axes
    assert bars(axes)[0].get_x() == pytest.approx(-0.01)


def analysed(scheme: str, *, truth: bool = True) -> Analysis:
    def path(time_s: Floats) -> Floats:
        return np.full((len(time_s), 2), 8.0)

    recording = simulate(plan_of(scheme, 20, 32), letter(32, "letter-B", 12), path)
    bare = Recording(recording.plan, recording.values, recording.frame_valid, recording.picture_time_s)
    return analyse(recording if truth else bare, tracking="per-frame", method="conventional")


def titles(figure: Figure) -> list[str]:
    return [axes.get_title() for axes in figure.axes]


@pytest.mark.parametrize(
    ("scheme", "truth", "panels", "pictures"),
    [
        (
            "fourier-hadamard",
            True,
            ["motion ignored", "motion measured and taken back", "the object, at frame 0", ""],
            ["summary", "image", "trajectory", "error"],
        ),
        (
            "fourier-hadamard",
            False,
            ["motion ignored", "motion measured and taken back", ""],
            ["summary", "image", "trajectory"],
        ),
        ("hadamard", False, ["inverse transform", "reconstructed"], ["summary", "image"]),
        ("fourier-3step", True, [""], ["summary", "trajectory", "error"]),
    ],
)
def test_each_scheme_fills_the_panels_and_pictures_that_it_can(
    scheme: str, *, truth: bool, panels: list[str], pictures: list[str], tmp_path: Path
) -> None:
    analysis = analysed(scheme, truth=truth)
    assert titles(summary_figure(analysis)) == panels
    written = write_pictures(analysis, tmp_path / "new", "run")
    assert [path.name for path in written] == [f"run-{name}.png" for name in pictures]
    assert write_pictures(analysis, tmp_path)[0] == tmp_path / "summary.png"
    with Image.open(written[0]) as picture:
        assert np.asarray(picture.convert("L")).std() > 10, "an empty picture"


def test_edge_times_add_the_picture_of_their_steps(tmp_path: Path) -> None:
    found = analysed("hadamard", truth=False)
    edges = np.arange(40.0).reshape(20, 2) * 50e-6
    timed = Recording(
        found.recording.plan, found.recording.values, found.recording.frame_valid, 50e-6, edge_time_s=edges
    )
    written = write_pictures(analyse(timed, method="conventional"), tmp_path)
    assert [path.name for path in written] == ["summary.png", "image.png", "timing.png"]


def test_a_place_for_pictures_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match="which is no folder and cannot be made one: File exists"):
        picture_folder(tmp_path / "taken")
    assert picture_folder(tmp_path / "a" / "b").is_dir()
