"""An image that turns and grows in the run."""

import math
from pathlib import Path

import numpy as np
import pytest

from protocols import Floats
from sim_backends.bench.image import AreaImage
from sim_backends.bench.pose import ChangingImage, turned
from tests.sim_backends.projector import PICTURE_S, SIZE, all_on, bench_with, dot, pixel, save, show

EVEN = AreaImage(np.ones((4, 6)), 1.0, 5.0, 6.0)
"""Six pixels wide and four high about (8, 8)."""


def _moments(image: Floats) -> tuple[Floats, Floats]:
    """Centre (x, y) in pixels, and the 2 x 2 covariance."""
    at = np.arange(len(image)) + 0.5
    light = image.sum()
    x, y = (image * at).sum() / light, (image * at[:, None]).sum() / light
    dx, dy = at - x, (at - y)[:, None]
    xy = float((image * dx * dy).sum() / light)
    covariance: Floats = np.array([[(image * dx**2).sum() / light, xy], [xy, (image * dy**2).sum() / light]])
    centre: Floats = np.array([x, y])
    return centre, covariance


def test_a_turn_by_a_right_angle_takes_right_to_down() -> None:
    """Cells 1 2 3 over 4 5 6, clockwise: 4 1, then 5 2, then 6 3, about the same centre."""
    image = AreaImage(np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]) / 6, 1.0, 10.0, 20.0)
    around = turned(image, 90.0)  # on half pixels
    columns = np.array([[4.0, 1.0], [5.0, 2.0], [6.0, 3.0]]) / 6
    lit = around.without_dark_borders()
    assert lit.cells == pytest.approx(np.kron(columns, np.ones((2, 2))))
    assert [lit.left_px, lit.top_px] == pytest.approx([10.5, 19.5])


def test_a_turned_image_has_no_more_cells_than_its_corners_need() -> None:
    """6 x 4 px by 30 degrees need 6 cos 30 + 4 sin 30 = 7.2 px of width and 6.5 of height: 16 and 14 cells of half a pixel."""
    assert turned(EVEN, 30.0).cells.shape == (14, 16)


@pytest.mark.parametrize("degrees", [0.0, 180.0, -180.0])
def test_half_a_turn_is_exact(degrees: float) -> None:
    image = AreaImage(np.random.default_rng(1).random((3, 5)), 1.0, 4.0, 6.0)
    want = np.rot90(image.cells, 2) if degrees else image.cells
    assert turned(image, degrees).on_grid(0, 0, 16, 1.0)[6:9, 4:9] == pytest.approx(want)


@pytest.mark.parametrize("degrees", [3.0, -3.0, 30.0, 72.5])
def test_a_turn_turns_the_second_moments_and_keeps_light_and_centre(degrees: float) -> None:
    """A rectangle of 6 x 4 has the variances 3 and 4/3; off the diagonal the turn puts sin cos (3 - 4/3).

    To each of the two, cells of half a pixel add up to 0.5^2 / 12 px^2 as means, and (0.5^2 - 0.25^2) / 12 as they are read here.
    """
    angle = math.radians(degrees)
    seen = turned(EVEN, degrees).on_grid(0.0, 0.0, 4 * SIZE, 0.25)
    centre, covariance = _moments(seen)
    assert seen.sum() == pytest.approx(24.0, rel=0.01)
    assert centre / 4 == pytest.approx([8.0, 8.0], abs=1e-9)
    assert covariance[0, 1] / 16 == pytest.approx(math.sin(angle) * math.cos(angle) * (3 - 4 / 3), abs=0.03)
    assert 0 < covariance.trace() / 16 - (3 + 4 / 3) < 2 * (1 / 48 + 1 / 64) + 0.01


def test_growth_is_exact_about_the_centre_and_keeps_the_brightness() -> None:
    """6 x 4 at one and a half is 9 x 6, from 3.5 to 12.5 and from 5 to 11."""
    seen = EVEN.on_grid(0.0, 0.0, SIZE, 1.0, np.array([1.5]))
    across = np.clip(np.minimum(np.arange(16) + 1, 12.5) - np.maximum(np.arange(16), 3.5), 0, 1)
    down = (np.arange(16) >= 5) & (np.arange(16) < 11)
    assert seen == pytest.approx(np.outer(down, across))


def test_a_run_ends_with_the_whole_growth_and_the_light_grows_with_the_area(tmp_path: Path) -> None:
    """Nine patterns and the guard: at the middle of picture k the part (k + 0.5) / 10 of the growth is there."""
    scene = {"object": "square", "object_height_px": 4, "start_px": (8.0, 8.0), "object_growth": 0.5}
    bench = bench_with(tmp_path, **scene)
    show(bench, [all_on()] * 9)
    part = (np.arange(9) + 0.5) / 10
    assert bench.counts(0, 9) == pytest.approx(16 * (1 + 0.5 * part) ** 2)


def test_a_run_ends_with_the_whole_turn(tmp_path: Path) -> None:
    """A bar of 8 x 2 pixels, a right angle in 10 pictures: 22.5 degrees are over after 2.5 of them, and 81 after nine.

    The pixel at its right end sees less and less of it; one below the middle, more and more.
    """
    cells = np.zeros((SIZE, SIZE))
    cells[7:9, 4:12] = 1.0
    bench = bench_with(tmp_path, object=save(tmp_path, cells), object_turn_deg=90.0)
    show(bench, [pixel(8, 11)] * 9)
    right = bench.counts(0, 9)
    show(bench, [pixel(11, 8)] * 9)
    below = bench.counts(0, 9)
    assert (right[0], right[8], below[0]) == (pytest.approx(1.0, abs=0.1), 0.0, 0.0)
    assert below[8] > 0.7  # at 76.5 degrees the bar is 2 px wide and ends 4 px below the middle
    show(bench, [pixel(4, 8)] * 9)
    assert bench.counts(0, 9)[8] < below[8]  # clockwise: the right end goes down, and leans to the right


def test_displacement_and_truth_stay_those_of_the_centre(tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_text("t_s,x_px,y_px\n0,0,0\n1,2000,0\n")
    scene = {
        "object": save(tmp_path, dot(6, 4)),
        "trajectory": "path.csv",
        "object_growth": 1.0,
        "object_turn_deg": 90.0,
    }
    bench = bench_with(tmp_path, **scene)
    show(bench, [all_on()] * 9)
    truth = bench.truth(np.array([0.0, 10 * PICTURE_S]))
    assert truth.displacement_px.tolist() == [[0.0, 0.0], [1.0, 0.0]]
    assert truth.image.tolist() == dot(6, 4).tolist()
    assert truth.background is None


def test_turned_images_are_made_in_steps_that_a_pixel_does_not_see() -> None:
    """3 degrees of an image whose corner is 3.6 px from its centre: 0.19 px of way, in steps of 1/32 px: seven images."""
    changing = ChangingImage(EVEN, turn_deg=6.0, run_s=2.0)
    time_s = np.linspace(0, 1, 500)
    poses = list(changing.poses(time_s))
    assert len(poses) == 7
    assert np.concatenate([which for which, _ in poses]).tolist() == list(range(500))
    assert changing.scale(time_s) is None


def test_a_whole_turn_has_a_thousand_steps() -> None:
    """EVEN goes 22.7 px along its circle, 725 steps of 1/32 px; one ten times as large would have 7,250."""
    time_s = np.linspace(0, 1, 5000)
    large = AreaImage(EVEN.cells, 10.0, 0.0, 0.0)
    seen = [sum(1 for _ in _Steps(image).poses(time_s)) for image in (EVEN, large)]
    assert seen == [726, 1001]


class _Steps(ChangingImage):
    """Turns by 360 degrees, and draws nothing."""

    def __init__(self, image: AreaImage) -> None:
        super().__init__(image, turn_deg=360.0)

    def _at(self, step: int, step_deg: float) -> AreaImage:
        return self.image


def test_an_image_that_does_not_turn_is_itself() -> None:
    ((which, image),) = ChangingImage(EVEN, growth=1.0).poses(np.zeros(3))
    assert which.tolist() == [0, 1, 2]
    assert image is EVEN


def test_a_huge_image_is_turned_on_coarser_cells() -> None:
    """One cell of 3,000 px: its diagonal of 4,243 px has 400 cells at most, of 10.6 px."""
    seen = turned(AreaImage(np.ones((1, 1)), 3000.0, 0.0, 0.0), 1.0)
    assert 10.0 < seen.cell_px <= 10.6067
    assert seen.cells.sum() * seen.cell_px**2 == pytest.approx(9e6, rel=1e-3)
