"""The augmented-Lagrangian solver against answers by hand and against another convex solver."""

import numpy as np
import pytest

from instrument.numerics import tv_augmented_lagrangian
from instrument.patterns import hadamard_order
from instrument.reconstruction import Field, ShiftedHadamard
from protocols import Floats, Singles
from tests.support.dense import DenseSingles

SIZE = 16


def _square() -> Singles:
    image = np.zeros((SIZE, SIZE), np.float32)
    image[5:11, 4:9] = 0.8
    return image


def _rows(count: int) -> ShiftedHadamard:
    drift = np.linspace(0, 4, count)[:, None] * [1.0, 0.5]
    return ShiftedHadamard.single(hadamard_order(SIZE, "tv", count), drift, Field(SIZE))


def _written_out(rows: ShiftedHadamard) -> DenseSingles:
    units = np.eye(rows.shape[0], dtype=np.float32)
    return DenseSingles(np.stack([rows.rmatvec(unit) for unit in units]).astype(np.float64), rows.image_shapes[0])


def _noisy(rows: ShiftedHadamard) -> Singles:
    noise = np.random.default_rng(3).standard_normal(rows.shape[0]).astype(np.float32)
    return rows.matvec(_square().ravel()) + noise


def _differences() -> Floats:
    """Periodic forward differences as a matrix, ``(2 pixels, pixels)``: down, then across."""
    unit = np.eye(SIZE * SIZE).reshape(-1, SIZE, SIZE)
    moved = [np.roll(unit, -1, axis) - unit for axis in (1, 2)]
    return np.concatenate([m.reshape(len(unit), -1).T for m in moved])


def _reference(matrix: Floats, values: Floats, weight: float) -> Floats:
    """Minimise 1/2 ||A x - b||^2 + weight TV(x), the linear equations of every step solved exactly (Boyd et al. 2011)."""
    pixels = matrix.shape[1]
    apart = np.concatenate([_differences(), np.eye(pixels)])
    stiff = weight  # jumps are of order 1, so that dual and primal variables are balanced
    solve = np.linalg.inv(matrix.T @ matrix + stiff * apart.T @ apart)
    back = matrix.T @ values
    copy, dual = np.zeros(3 * pixels), np.zeros(3 * pixels)
    image = np.zeros(pixels)
    for _ in range(2000):
        image = solve @ (back + stiff * apart.T @ (copy - dual))
        wanted = apart @ image + dual
        length = np.tile(np.hypot(wanted[:pixels], wanted[pixels : 2 * pixels]), 2)
        copy = wanted.copy()
        copy[: 2 * pixels] *= np.maximum(0, 1 - weight / stiff / np.maximum(length, 1e-300))
        copy[2 * pixels :] = np.maximum(wanted[2 * pixels :], 0)
        dual = wanted - copy
    return np.maximum(image, 0).reshape(SIZE, SIZE)


def periodic_tv(image: Floats) -> float:
    """Isotropic total variation with the image continued beyond its border by its other side."""
    down, across = np.roll(image, -1, 0) - image, np.roll(image, -1, 1) - image
    return float(np.hypot(down, across).sum())


def _cost(matrix: Floats, values: Floats, weight: float, image: Floats) -> float:
    residual = matrix @ image.ravel() - values
    return float(residual @ residual) / 2 + weight * periodic_tv(image)


def test_total_variation_of_a_square_counts_its_edges_and_the_corner_where_both_meet() -> None:
    """6 x 5 px of 0.8: 6 + 5 upper and left edges, and below and right 5 + 6 pixels, one of which holds both: sqrt 2."""
    assert periodic_tv(_square().astype(np.float64)) == pytest.approx(0.8 * (2 * 6 + 2 * 5 - 2 + np.sqrt(2)))


def test_of_a_stripe_the_contrast_is_lowered_by_four_lambda_over_the_width_on_each_side() -> None:
    """A = 1, half of the columns lit: TV = 2 h (high - low), so that lambda 2 h = (h w / 2) (1 - high)."""
    stripe = np.zeros((SIZE, SIZE), np.float32)
    stripe[:, 4:12] = 1
    state = tv_augmented_lagrangian(
        DenseSingles(np.eye(SIZE * SIZE), (SIZE, SIZE)), stripe.ravel(), mu=4, iterations=4000
    )
    lost = 4 * state.weight / SIZE
    assert 0.05 < lost < 0.07
    assert np.allclose(state.image[:, 4:12], 1 - lost, atol=2e-4)
    assert np.allclose(state.image[:, :4], lost, atol=2e-4)


@pytest.mark.parametrize("mu", [16.0, 256.0])
def test_it_ends_where_another_solver_of_the_same_problem_does(mu: float) -> None:
    rows = _rows(100)
    values, dense = _noisy(rows), _written_out(rows)
    state = tv_augmented_lagrangian(rows, values, mu=mu, tolerance=1e-7, iterations=6000)
    reference = _reference(dense.matrix, values.astype(np.float64), state.weight)
    reached, least = (
        _cost(dense.matrix, values.astype(np.float64), state.weight, image.astype(np.float64))
        for image in (state.image, reference)
    )
    assert reached == pytest.approx(least, rel=1e-3)
    assert np.abs(state.image - reference).max() < 0.02
    assert state.image.min() >= 0


def test_dense_and_structured_rows_give_the_same_image() -> None:
    rows = _rows(100)
    values = _noisy(rows)
    images = [tv_augmented_lagrangian(each, values, mu=64).image for each in (rows, _written_out(rows))]
    assert np.abs(images[0] - images[1]).max() < 1e-3


def test_values_twice_as_large_give_an_image_twice_as_bright() -> None:
    """The stretch of b makes mu mean the same, whatever the unit: exact where both ranges are clipped to the same end."""
    rows = _rows(100)
    values = _noisy(rows)
    one, two = (tv_augmented_lagrangian(rows, np.float32(gain) * values, mu=64).image for gain in (1000, 2000))
    assert np.abs(two / 2 - one).max() < 1e-3 * one.max()


def test_who_watches_sees_every_step_and_the_last_image() -> None:
    rows = _rows(60)
    seen: list[Floats] = []
    state = tv_augmented_lagrangian(rows, _noisy(rows), iterations=25, watch=seen.append)
    assert len(seen) == state.iterations == 25
    assert np.allclose(seen[-1], state.image, atol=1e-6)


def test_dark_values_give_a_dark_image() -> None:
    rows = _rows(40)
    state = tv_augmented_lagrangian(rows, np.zeros(40, np.float32))
    assert not state.image.any()
