"""An image out of focus."""

from pathlib import Path

import numpy as np
import pytest

from protocols import Floats, InputError
from sim_backends.bench.blur import blurred
from sim_backends.bench.image import AreaImage
from tests.sim_backends.projector import all_on, bench_with, dot, save, show, values


def _moments(image: AreaImage) -> tuple[float, Floats, Floats]:
    """Light, centre (x, y) and variance (x, y) of an image, each cell taken at its centre."""
    rows, columns = image.cells.shape
    x: Floats = image.left_px + (np.arange(columns, dtype=np.float64) + 0.5) * image.cell_px
    y: Floats = image.top_px + (np.arange(rows, dtype=np.float64) + 0.5) * image.cell_px
    light = image.cells.sum()
    across, down = image.cells.sum(0) / light, image.cells.sum(1) / light
    at_x, at_y = float((across * x).sum()), float((down * y).sum())
    centre = np.array([at_x, at_y])
    spread = np.array([float((across * (x - at_x) ** 2).sum()), float((down * (y - at_y) ** 2).sum())])
    return float(light) * image.cell_px**2, centre, spread


@pytest.mark.parametrize("sigma_px", [0.2, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("cell_px", [0.25, 1.0])
def test_a_blur_adds_its_variance_and_keeps_light_and_centre(sigma_px: float, cell_px: float) -> None:
    """A cell of side a has the variance (a^2 - b^2) / 12 on its parts of side b, read at their centres."""
    image = AreaImage(np.full((1, 1), 0.8), cell_px, 3.0, 5.0)
    spread = blurred(image, sigma_px)
    light, centre, variance = _moments(spread)
    assert light == pytest.approx(0.8 * cell_px**2)
    assert centre == pytest.approx([3.0 + cell_px / 2, 5.0 + cell_px / 2])
    assert variance == pytest.approx(np.full(2, sigma_px**2 + (cell_px**2 - spread.cell_px**2) / 12), rel=5e-3)


def test_the_blurred_image_is_what_stands_on_the_modulator_and_in_the_truth(tmp_path: Path) -> None:
    """A pixel of light spreads over the pixels by the Gaussian, with its variance of 1 px^2."""
    bench = bench_with(tmp_path, object=save(tmp_path, dot(8, 7)), blur_px=1.0)
    show(bench, [all_on()])
    image = bench.truth(np.zeros(1)).image
    _, centre, variance = _moments(AreaImage(image, 1.0, 0.0, 0.0))
    assert centre == pytest.approx([7.5, 8.5])
    assert variance == pytest.approx([1.0, 1.0], rel=5e-3)
    assert bench.counts(0, 1)[0] == pytest.approx(image.sum())


def test_the_background_is_in_the_same_plane_of_focus(tmp_path: Path) -> None:
    save(tmp_path, dot(8, 7), "still.npy")
    bench = bench_with(tmp_path, object=save(tmp_path, dot(2, 2)), background="still.npy", blur_px=1.0)
    assert values(bench, [all_on()])[0] == pytest.approx(2.0, abs=0.02)
    background = bench.truth(np.zeros(1)).background
    assert background is not None
    assert _moments(AreaImage(background, 1.0, 0.0, 0.0))[2] == pytest.approx([1.0, 1.0], rel=5e-3)


def test_without_a_blur_the_image_is_the_same_one() -> None:
    image = AreaImage(np.ones((2, 2)), 1.0, 0.0, 0.0)
    assert blurred(image, 0.0) is image


def test_a_blur_over_too_many_cells_is_refused_before_room_is_taken_for_it() -> None:
    with pytest.raises(InputError, match=r"blur_px = 100 on a picture with cells of 0\.001 px"):
        blurred(AreaImage(np.ones((2, 2)), 1e-3, 0.0, 0.0), 100.0)
