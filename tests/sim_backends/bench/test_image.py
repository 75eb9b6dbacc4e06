"""Area sampling: the light that a grid of pixels sees of displaced square cells."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols import Floats
from sim_backends.bench.image import AreaImage, Window

RANDOM = np.random.default_rng(5)


def whole_field(cells: Floats, size: int) -> AreaImage:
    return AreaImage(cells, size / len(cells), 0.0, 0.0)


def test_an_image_at_rest_on_its_own_grid_is_seen_as_it_is() -> None:
    cells = RANDOM.random((8, 8))
    assert np.allclose(whole_field(cells, 8).on_grid(0.0, 0.0, 8, 1.0), cells, atol=1e-14)


def test_a_pixel_moved_by_a_quarter_gives_a_quarter_of_its_light_to_the_next() -> None:
    cells = np.zeros((8, 8))
    cells[3, 2] = 1.0
    seen = whole_field(cells, 8).on_grid(0.25, 0.0, 8, 1.0)
    assert (seen[3, 2], seen[3, 3]) == (0.75, 0.25)
    assert seen.sum() == 1.0


def test_positive_y_is_down() -> None:
    cells = np.zeros((8, 8))
    cells[3, 2] = 1.0
    assert whole_field(cells, 8).on_grid(0.0, 2.0, 8, 1.0)[5, 2] == 1.0


def test_a_finer_picture_is_averaged_over_each_pixel() -> None:
    cells = RANDOM.random((32, 32))
    expected = cells.reshape(8, 4, 8, 4).mean((1, 3))
    assert np.allclose(whole_field(cells, 8).on_grid(0.0, 0.0, 8, 1.0), expected, atol=1e-13)


def test_a_finer_picture_moved_by_one_of_its_own_cells_is_the_shifted_picture_averaged() -> None:
    cells = np.zeros((32, 32))
    cells[8:20, 8:20] = RANDOM.random((12, 12))
    expected = np.roll(cells, (-2, 1), (0, 1)).reshape(8, 4, 8, 4).mean((1, 3))
    assert np.allclose(whole_field(cells, 8).on_grid(0.25, -0.5, 8, 1.0), expected, atol=1e-13)


def test_what_leaves_the_field_is_dark() -> None:
    ones = np.ones((8, 8))
    assert whole_field(ones, 8).on_grid(3.5, 0.0, 8, 1.0).sum() == pytest.approx(4.5 * 8)
    assert whole_field(ones, 8).on_grid(-20.0, 0.0, 8, 1.0).sum() == 0.0


@given(dx=st.floats(-3, 3), dy=st.floats(-3, 3), side=st.sampled_from([5, 8, 12, 24]))
def test_light_is_neither_lost_nor_made_while_the_object_is_inside(dx: float, dy: float, side: int) -> None:
    cells = np.random.default_rng(side).random((side, side))
    image = AreaImage(cells, 8 / side, 4.0, 4.0)
    assert image.on_grid(dx, dy, 16, 1.0).sum() == pytest.approx(cells.sum() * (8 / side) ** 2, rel=1e-12)


@given(dx=st.floats(-9, 9), dy=st.floats(-9, 9))
def test_a_finer_grid_adds_up_to_the_coarse_one(dx: float, dy: float) -> None:
    image = AreaImage(np.random.default_rng(1).random((6, 4)), 0.7, 5.3, 4.1)
    fine = image.on_grid(dx, dy, 32, 0.5).reshape(16, 2, 16, 2).sum((1, 3))
    assert np.allclose(fine, image.on_grid(dx, dy, 16, 1.0), atol=1e-12)


def test_the_window_holds_all_of_the_object_and_little_more() -> None:
    image = AreaImage(np.ones((2, 3)), 1.0, 4.0, 6.0)
    assert image.window(np.array([[0.5, 0.0]]), 16, 1.0) == Window(top=6, bottom=8, left=4, right=8)
    assert image.window(np.array([[0.5, 0.0]]), 32, 0.5) == Window(top=12, bottom=16, left=9, right=15)
    assert image.window(np.array([[0.5, 0.0], [-2.0, 1.5]]), 16, 1.0) == Window(top=6, bottom=10, left=2, right=8)
    assert image.window(np.array([[100.0, 0.0]]), 16, 1.0).empty


def test_many_displacements_at_once_are_seen_as_one_by_one() -> None:
    image = AreaImage(RANDOM.random((6, 5)), 0.8, 5.0, 4.0)
    at_px = RANDOM.uniform(-4, 6, (20, 2))
    window = Window(0, 16, 0, 16)
    one_by_one = [image.on_grid(dx, dy, 16, 1.0) for dx, dy in at_px.tolist()]
    assert np.allclose(image.light(at_px, window, 1.0), np.stack(one_by_one), atol=1e-13)
