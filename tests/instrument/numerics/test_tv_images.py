"""Total variation of several images at once, against one image at a time."""

from collections.abc import Sequence

import numpy as np
import pytest

from instrument.numerics import Layered, Stacked, TvState, Unseen, total_variation
from protocols import Singles
from tests.support.dense import DenseSingles

SHAPES = ((8, 8), (6, 10))


def _image(number: int) -> Singles:
    image = np.zeros(SHAPES[number], np.float32)
    if number == 0:
        image[2:6, 1:5] = 1.0
    else:
        image[0:3, 4:10] = 0.6
    return image


def _values(number: int, scale: float = 1.0, noise: float = 1.0) -> Singles:
    """An image seen pixel by pixel, 20 times its noise."""
    image = _image(number)
    white = np.random.default_rng(number + 1).standard_normal(image.size)
    return np.asarray(scale * 20 * image.ravel() + noise * white, np.float32)


def _identity(number: int, scale: float = 1.0) -> DenseSingles:
    size = _image(number).size
    return DenseSingles(scale * 20 * np.eye(size), SHAPES[number])


def _both(scale: float = 1.0) -> Stacked:
    """Values of the first image, then those of the second one."""
    first, second = _identity(0), _identity(1, scale)
    return Stacked(
        Layered((first, Unseen(first.shape[0], (SHAPES[1],)))),
        Layered((Unseen(second.shape[0], (SHAPES[0],)), second)),
    )


def _alone(number: int, strength: float, reweightings: int | None = 0) -> TvState:
    return total_variation(
        _identity(number), _values(number), strength=strength, reweightings=reweightings, tolerance=0, iterations=1000
    )


def _together(
    strength: float, scale: float = 1.0, reweightings: int | None = 0, finer: Sequence[int] | None = None
) -> TvState:
    values = np.concatenate([_values(0), _values(1, scale, noise=scale)])
    return total_variation(
        _both(scale), values, strength=strength, finer=finer, reweightings=reweightings, tolerance=0, iterations=1000
    )


@pytest.mark.parametrize("reweightings", [0, 2])
def test_two_images_that_do_not_meet_are_as_each_alone(reweightings: int) -> None:
    """The noise of a pixel projected back is a sample of the same 1: lambda differs by a few hundredths, as that is drawn."""
    both = _together(1.0, reweightings=reweightings)
    assert [image.shape for image in both.images] == list(SHAPES)
    for number in range(2):
        alone = _alone(number, 1.0, reweightings)
        np.testing.assert_allclose(both.images[number], alone.image, atol=0.02)
        assert np.sqrt(np.mean((both.images[number] - _image(number)) ** 2)) < 0.05


def test_no_gradient_reaches_from_one_image_to_the_other() -> None:
    """Even images of 1 and 0.2, without noise: each has no variation at all, however strong the smoothing is."""
    values = np.concatenate([np.full(64, 20.0), np.full(60, 4.0)]).astype(np.float32)
    state = total_variation(_both(), values, strength=100.0, reweightings=0, tolerance=0, iterations=500)
    np.testing.assert_allclose(state.images[0], 1.0, atol=1e-4)
    np.testing.assert_allclose(state.images[1], 0.2, atol=1e-4)


def test_an_image_of_smaller_pixels_is_smoothed_in_proportion() -> None:
    """Smoothed without end, an image is its mean: 16 of 64 pixels."""
    state = _together(1.0, finer=[50, 1])
    np.testing.assert_allclose(state.images[0], float(_values(0).mean()) / 20, atol=0.01)
    assert state.images[1].max() > 0.5


@pytest.mark.parametrize("scale", [0.1, 10.0])
def test_seen_more_or_less_strongly_an_image_is_solved_for_alike(scale: float) -> None:
    """The second image's rows, values and noise times a factor: its own problem times the square of it, with lambda in step."""
    even, uneven = _together(1.0), _together(1.0, scale)
    assert even.scales == pytest.approx((1.0, 1.0), rel=0.01)
    assert uneven.scales[0] / uneven.scales[1] == pytest.approx(scale, rel=0.01)
    np.testing.assert_allclose(uneven.images[0], even.images[0], atol=0.01)


def test_the_solution_does_not_depend_on_the_scale_it_is_worked_out_at() -> None:
    """The same rows and values from a start with other scales, and the eigenvalue that belongs to them."""
    even = _together(1.0)
    zero = TvState.zero(SHAPES, even.eigenvalue * 4)
    start = TvState(zero.images, zero.duals, zero.eigenvalue, float("nan"), 0, 1.0, 0.0, (1.0, 2.0))
    values = np.concatenate([_values(0), _values(1)])
    other = total_variation(_both(), values, strength=1.0, reweightings=0, tolerance=0, iterations=2000, start=start)
    for number in range(2):
        np.testing.assert_allclose(other.images[number], even.images[number], atol=0.005)


def test_a_warm_start_goes_on_from_both_images() -> None:
    cold = _together(1.0)
    values = np.concatenate([_values(0), _values(1)])
    warm = total_variation(_both(), values, strength=1.0, reweightings=0, tolerance=1e-4, iterations=1000, start=cold)
    assert warm.iterations - cold.iterations <= 20
    for number in range(2):
        np.testing.assert_allclose(warm.images[number], cold.images[number], atol=1e-3)
    assert warm.image is warm.images[0]
    assert warm.dual is warm.duals[0]
