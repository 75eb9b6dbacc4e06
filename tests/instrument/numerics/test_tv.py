"""The total-variation solver on small problems whose answer is known."""

import numpy as np
import pytest

from instrument.numerics import Weighted, total_variation
from instrument.numerics.tv import relaxation_of
from instrument.patterns import hadamard_order
from instrument.reconstruction import Field, Region, ShiftedHadamard
from protocols import Singles

SIZE = 32


def _square() -> Singles:
    image = np.zeros((SIZE, SIZE), np.float32)
    image[10:20, 8:18] = 1.0
    return image


def _rows(count: int, sigma: float) -> tuple[Weighted, Singles]:
    """Whitened rows of an object that drifts, and noisy whitened values of the square."""
    drift = np.linspace(0, 8, count)[:, None] * [1.0, 0.5]
    rows = ShiftedHadamard.single(hadamard_order(SIZE, "tv", count), drift, Field(SIZE))
    noise = np.random.default_rng(1).standard_normal(count).astype(np.float32)
    weight = np.full(count, 1 / sigma, np.float32)
    return Weighted(rows, weight), weight * rows.matvec(_square().ravel()) + noise


def _error_db(image: Singles) -> float:
    return float(10 * np.log10(np.mean((image - _square()) ** 2)))


def test_a_fifth_of_the_rows_give_the_square() -> None:
    rows, values = _rows(204, sigma=2.0)
    state = total_variation(rows, values)
    assert _error_db(state.image) < -30
    assert state.image.min() >= 0
    assert state.misfit == pytest.approx(1.0, abs=0.1)


def test_edges_freed_give_back_the_contrast_that_total_variation_takes() -> None:
    """Mean inside the square: lost by plain TV, nearly whole after reweighting and after a Bregman step."""
    rows, values = _rows(204, sigma=6.0)

    def contrast(reweightings: int, bregman_steps: int) -> float:
        state = total_variation(rows, values, reweightings=reweightings, bregman_steps=bregman_steps, strength=5)
        return float(state.image[10:20, 8:18].mean())

    plain, freed, bregman = contrast(0, 0), contrast(1, 0), contrast(0, 1)
    assert plain < 0.95
    assert freed > 0.96
    assert bregman > 0.96


def test_without_noise_the_image_is_near_exact() -> None:
    rows, values = _rows(300, sigma=0.02)
    noise = np.random.default_rng(1).standard_normal(300).astype(np.float32)
    state = total_variation(rows, values - noise)
    assert _error_db(state.image) < -50


def test_a_warm_start_needs_fewer_iterations_and_ends_at_the_same_image() -> None:
    rows, values = _rows(204, sigma=2.0)
    cold = total_variation(rows, values, reweightings=0, tolerance=0.003, iterations=500)
    warm = total_variation(rows, values, reweightings=0, tolerance=0.003, iterations=500, start=cold)
    assert warm.iterations - cold.iterations <= cold.iterations / 3
    assert np.abs(warm.image - cold.image).max() < 0.02


def test_a_tighter_tolerance_takes_more_iterations() -> None:
    rows, values = _rows(204, sigma=2.0)
    loose, tight = (total_variation(rows, values, tolerance=t, iterations=1000).iterations for t in (0.1, 0.001))
    assert loose < tight < 2000


def test_values_that_no_image_explains_take_at_most_four_times_the_iterations() -> None:
    """Random values of 1,000 times the stated noise."""
    rows, _ = _rows(204, sigma=2.0)
    values = 1000 * np.random.default_rng(7).standard_normal(204).astype(np.float32)
    state = total_variation(rows, values, tolerance=0, iterations=35)
    assert state.iterations <= 4 * 35
    assert state.misfit > 2


def test_the_solution_is_where_the_optimality_condition_says() -> None:
    """Plain TV at the optimum: 0 = <x, A'(A x - b)> + lambda TV(x), as both are homogeneous of degree one at x >= 0."""
    rows, values = _rows(150, sigma=3.0)
    state = total_variation(rows, values, reweightings=0, tolerance=0, iterations=3000)
    x = state.image
    data_term = -float(np.vdot(x, rows.rmatvec(rows.matvec(x.ravel()) - values).reshape(x.shape)))
    down, across = np.zeros_like(x), np.zeros_like(x)
    down[:-1], across[:, :-1] = np.diff(x, axis=0), np.diff(x, axis=1)
    variation = float(np.hypot(down, across).sum())
    noise = np.random.default_rng(0).standard_normal(150).astype(np.float32)
    strength = 3.0 * float(np.sqrt(np.mean(rows.rmatvec(noise) ** 2)))
    assert data_term == pytest.approx(strength * variation, rel=1e-3)


def test_dark_values_give_a_dark_image() -> None:
    rows = ShiftedHadamard.single(hadamard_order(SIZE, "tv", 50), np.zeros((50, 2)), Field(SIZE), Region(0, 0, 9, 11))
    state = total_variation(rows, np.zeros(50, np.float32))
    assert state.image.shape == (9, 11)
    assert not state.image.any()


def test_the_iteration_converges_for_all_patterns_of_an_object_at_rest() -> None:
    """All 4,096 patterns of 64 x 64 pixels: plain total variation must come to explain the values within their noise."""
    count, weight = 4096, np.full(4096, 1 / 6, np.float32)
    rows = Weighted(ShiftedHadamard.single(hadamard_order(64, "tv", count), np.zeros((count, 2)), Field(64)), weight)
    square = np.zeros((64, 64), np.float32)
    square[10:30, 12:40] = 1.0
    values = rows.matvec(square.ravel()) + np.random.default_rng(0).standard_normal(count).astype(np.float32)
    state = total_variation(rows, values, reweightings=0, tolerance=0, iterations=400)
    assert state.misfit == pytest.approx(1.0, abs=0.1)


def test_the_relaxation_stays_below_its_bound() -> None:
    """All patterns at rest: A'A = 4096 everywhere, 1 / tau - sigma K'K = 1/2 for a checkerboard: 2 - 2 / (2 x 1.05) - 0.02."""
    whole = ShiftedHadamard.single(hadamard_order(64, "tv", 4096), np.zeros((4096, 2)), Field(64))
    assert relaxation_of(whole, 4096 * 1.05) == pytest.approx(2 - 1 / 1.05 - 0.02, abs=1e-3)
    smooth = ShiftedHadamard.single(hadamard_order(64, "tv", 400), np.zeros((400, 2)), Field(64))
    assert relaxation_of(smooth, 4096 * 1.05) == 1.7
