# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false
# matplotlib leaves much of its types open.
"""What is drawn: the numbers in the lines, bands, images and bars, read back from the figure."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from PIL import Image

from instrument.analysis import Analysis, analyse
from instrument.config import RunTable
from instrument.recording import Recording
from instrument.views import picture_folder, write_pictures
from instrument.views.images import draw_image, image_figure, mark_centroid, round_length
from instrument.views.pictures import foot_of
from instrument.views.plots import error_figure, timing_figure, trajectory_figure
from instrument.views.style import X_COLOUR, Y_COLOUR, add_foot, drawable, new_figure, save
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
    assert titles(image_figure(np.eye(4), None)) == ["reconstructed, at frame 0", ""]
    assert titles(image_figure(np.eye(4), np.eye(4))) == ["reconstructed, at frame 0", "truth", ""]


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
    """Steps of 50.00, 50.02, 49.98 us, and one over a missing edge, which is none. The clock ticks in 20 ns: so wide is a bar."""
    edges_us = np.array([[0.0, 50.0, 100.02], [150.0, np.nan, 250.0]])
    (axes,) = timing_figure(edges_us * 1e-6, 50e-6).axes
    drawn = bars(axes)
    assert [bar.get_height() for bar in drawn] == [1, 1, 1]
    assert [bar.get_x() for bar in drawn] == pytest.approx([-30, -10, 10])
    assert axes.get_xlabel() == "sync period minus 50 us, ns   (bars of 20 ns)"


def test_a_perfect_clock_is_one_bar_in_the_middle_of_ten_nanoseconds() -> None:
    """Digits of double precision are no deviation: 0.1 s and 50 us differ by 1e-17 s from step to step."""
    (axes,) = timing_figure(np.arange(2000.0) * 50e-6, 50e-6).axes
    drawn = bars(axes)
    assert len(drawn) == 81
    assert [bar.get_height() for bar in drawn if bar.get_height()] == [1999]
    assert drawn[40].get_x() == pytest.approx(-0.125)


def test_many_small_steps_share_bars_and_none_is_left_out() -> None:
    offsets_ns = np.random.default_rng(1).uniform(-500, 500, 4000)
    edges_s = np.cumsum(50e-6 + offsets_ns * 1e-9)
    (axes,) = timing_figure(edges_s, 50e-6).axes
    assert len(bars(axes)) == 81
    assert sum(bar.get_height() for bar in bars(axes)) == 3999


@pytest.mark.parametrize(("longest", "length"), [(38.4, 20), (50, 50), (9.99, 5), (0.3, 0.2), (0.1, 0.1), (1.0, 1.0)])
def test_a_scale_bar_has_a_round_length(longest: float, length: float) -> None:
    assert round_length(longest) == pytest.approx(length)


@pytest.mark.parametrize(("px_per_mm", "words", "length_px"), [(None, "20 px", 20.0), (7.2, "5 mm", 36.0)])
def test_an_image_is_drawn_in_px_of_the_field_with_a_bar(px_per_mm: float | None, words: str, length_px: float) -> None:
    """An image on half pixels covers the same field; the first pixel of the patterns has its middle at 0."""
    axes = new_figure(3, 3).subplots()
    draw_image(axes, np.eye(256), "fine", size_px=128, px_per_mm=px_per_mm)
    assert tuple(axes.get_images()[0].get_extent()) == (-0.5, 127.5, 127.5, -0.5)
    assert axes.get_xlabel() == "x, px   (grey 0 to 1)"
    (bar,) = axes.get_lines()
    left, right = np.asarray(bar.get_xdata()).tolist()
    assert right - left == pytest.approx(length_px)
    (label,) = axes.texts
    assert label.get_text() == words
    assert label.get_position()[0] == pytest.approx((left + right) / 2)


def test_the_cross_is_explained() -> None:
    axes = new_figure(3, 3).subplots()
    draw_image(axes, np.eye(8), "image")
    mark_centroid(axes, np.array([2.0, 5.0]))
    legend = axes.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["centroid"]


def test_a_path_has_bands_of_its_own_uncertainty_and_what_a_parabola_leaves_of_it() -> None:
    """A parabola and a rest leave nothing; where sigma is not known, there is no band."""
    time_s = np.arange(5.0)
    path = np.stack([time_s**2, np.zeros(5)], axis=1)
    sigma = np.full((5, 2), 0.5)
    sigma[4, 1] = np.inf
    figure = trajectory_figure(time_s, path, None, sigma_px=sigma)
    above, below = figure.axes
    band = np.asarray(above.collections[0].get_paths()[0].vertices)
    assert (band[:, 1].min(), band[:, 1].max()) == (-1.0, 17.0)
    drawn_x, drawn_y = (np.asarray(line.get_ydata(), np.float64) for line in below.get_lines()[:2])
    assert np.abs(drawn_x).max() < 1e-9
    assert np.abs(drawn_y).max() < 1e-9
    band_y = np.asarray(below.collections[1].get_paths()[0].vertices)
    assert band_y[:, 0].max() == 3.0, "where nothing is known there is no band"
    assert np.abs(band_y[:, 1]).max() == pytest.approx(1.0)


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_of_a_few_frames_a_parabola_leaves_nothing(frames: int) -> None:
    time_s = np.arange(float(frames))
    path = np.stack([1 + time_s**2, time_s], axis=1)
    below = trajectory_figure(time_s, path, None, sigma_px=np.ones((frames, 2))).axes[1]
    assert max(np.abs(np.asarray(line.get_ydata(), np.float64)).max() for line in below.get_lines()[:2]) < 1e-9


def test_a_calibrated_path_has_a_scale_in_mm() -> None:
    figure = trajectory_figure(TIME_S, PATH_PX, None, px_per_mm=10.0)
    pixels, millimetres = figure.axes
    assert np.asarray(millimetres.get_ylim()) * 10 == pytest.approx(np.asarray(pixels.get_ylim()))
    assert millimetres.get_ylabel() == "displacement, mm"


def test_the_foot_is_below_all_panels_and_nothing_of_it_is_cut() -> None:
    figure = new_figure(4, 2)
    figure.subplots().set_title("a title")
    add_foot(figure, "word " * 60, ["doubt " * 30])
    figure.draw_without_rendering()
    assert " ".join(text.get_text() for text in figure.texts) == ("! " + "doubt " * 30 + "word " * 60).strip()
    box, panel = figure.bbox, figure.axes[0].get_tightbbox()
    assert panel is not None
    for text in figure.texts:
        extent = text.get_window_extent()
        assert box.x0 <= extent.x0
        assert extent.x1 <= box.x1
        assert box.y0 <= extent.y0
        assert extent.y1 < panel.y0
    assert panel.y1 <= box.y1


def test_a_name_from_anywhere_is_drawn_as_it_stands() -> None:
    """No formula, no control character, no letter that the font lacks, which would warn."""
    assert drawable("a$b^2$ \x1b[2J \u4e2d \u00e9") == "a$b^2$ \\x1b[2J \\u4e2d \u00e9"
    figure = new_figure(4, 2)
    add_foot(figure, "a$b^{$ \x1b \u4e2d.h5")
    figure.draw_without_rendering()
    assert [text.get_text() for text in figure.texts] == ["a$b^{$ \\x1b \\u4e2d.h5"]


@pytest.mark.parametrize(("kind", "begin"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_pictures_are_what_their_names_end_with(kind: str, begin: bytes, tmp_path: Path) -> None:
    figure = new_figure(2, 2)
    figure.subplots().set_title("letters")
    written = save(figure, tmp_path / f"a.{kind}").read_bytes()
    assert written.startswith(begin)
    assert kind != "svg" or b">letters<" in written


def analysed(scheme: str, *, truth: bool = True, way_px: float = 6.0) -> Analysis:
    """An object that goes so many px right and down in the run, which takes 6 ms."""

    def path(time_s: Floats) -> Floats:
        return np.stack([8.0 + way_px * time_s / 6e-3] * 2, axis=1)

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
            ["motion ignored", "motion measured and taken back", "the object, at frame 0", "", ""],
            ["summary", "image", "trajectory", "error"],
        ),
        (
            "fourier-hadamard",
            False,
            ["motion ignored", "motion measured and taken back", "", ""],
            ["summary", "image", "trajectory"],
        ),
        ("hadamard", False, ["inverse transform", "reconstructed"], ["summary", "image"]),
        ("fourier-3step", True, ["", ""], ["summary", "trajectory", "error"]),
    ],
)
def test_each_scheme_fills_the_panels_and_pictures_that_it_can(
    scheme: str, *, truth: bool, panels: list[str], pictures: list[str], tmp_path: Path
) -> None:
    analysis = analysed(scheme, truth=truth)
    assert titles(summary_figure(analysis)) == panels
    written = write_pictures(analysis, tmp_path / "new", "run")
    assert foot_of(analysis).startswith(f"{scheme}, 20 frames, 20000 patterns/s, 32 x 32 px, at rest | ")
    about = RunTable(title="first light", sample="chrome B")
    titled = replace(analysis.recording, plan=analysis.recording.plan.model_copy(update={"run": about}))
    foot = foot_of(replace(analysis, recording=titled))
    assert foot.startswith(f"first light, sample chrome B | {scheme}, 20 frames")
    assert [path.name for path in written] == [f"run-{name}.png" for name in pictures]
    with Image.open(written[0]) as picture:
        assert np.asarray(picture.convert("L")).std() > 10, "an empty picture"


def test_where_no_uncertainty_is_stated_no_band_is_drawn() -> None:
    """The numbers of a path of few frames are there, and not to be believed."""
    stated = analysed("fourier-hadamard", truth=False)
    unsure = replace(stated, figures=stated.figures.model_copy(update={"sigma_px": None}))
    assert stated.trajectory is not None
    assert np.isfinite(stated.trajectory.sigma_px).any()
    assert len(summary_figure(stated).axes) == 4
    assert len(summary_figure(unsure).axes) == 3
    assert not any(axes.collections for axes in summary_figure(unsure).axes)
    assert "polygon" in stated._repr_html_()  # pyright: ignore[reportPrivateUsage] - as a notebook asks for it
    assert "polygon" not in unsure._repr_html_()  # pyright: ignore[reportPrivateUsage]


def test_an_object_at_rest_is_not_said_to_have_moved() -> None:
    first, second, *_ = titles(summary_figure(analysed("fourier-hadamard", truth=False, way_px=0.0)))
    assert first == "taken as at rest"
    assert second.startswith("moved 0.")
    assert second.endswith(" px, taken back")


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
