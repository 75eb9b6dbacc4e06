"""What is said of a spline: its freedom, its cost, its likelihood over gaps, and its limits."""

from math import comb

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import null_space

from instrument.numerics import Spline
from protocols import Floats


def _differences(size: int, order: int) -> Floats:
    """Write each p-th difference as a row of binomial coefficients."""
    matrix = np.zeros((size - order, size))
    for row in range(size - order):
        for k in range(order + 1):
            matrix[row, row + k] = (-1) ** (order - k) * comb(order, k)
    return matrix


def _trace(weights: Floats, order: int, strength: float) -> float:
    """Give the trace of the matrix that makes values of data."""
    difference = _differences(len(weights), order)
    normal = np.diag(weights) + strength * difference.T @ difference
    return float(np.trace(np.linalg.solve(normal, np.diag(weights))))


@pytest.mark.parametrize("strength", [0.1, 3.0, 200.0])
def test_the_degrees_of_freedom_of_order_1_are_the_trace_to_every_digit(strength: float) -> None:
    """Of first differences the modes are cosines, whose eigenvalues 4 sin^2(pi k / 2n) are exact."""
    found = Spline.through(np.arange(40.0), np.ones(40), 1, strength).degrees_of_freedom
    assert found == pytest.approx(_trace(np.ones(40), 1, strength), rel=1e-10)


@pytest.mark.parametrize(("order", "strength"), [(2, 1.0), (2, 1e3), (3, 1.0), (3, 1e4), (4, 1e5)])
def test_the_degrees_of_freedom_of_higher_orders_are_the_trace_within_two_percent(order: int, strength: float) -> None:
    found = Spline.through(np.arange(200.0), np.ones(200), order, strength).degrees_of_freedom
    assert found == pytest.approx(_trace(np.ones(200), order, strength), rel=0.02)


def test_a_datum_in_two_has_half_the_weight_of_every_datum() -> None:
    """200 places, 100 data: each counts as 1/2, so that strength 1,000 works as 2,000 does, and the trace is of 100 data."""
    weights = np.tile([1.0, 0.0], 100)
    found = Spline.through(np.arange(200.0), weights, 2, 1e3)
    assert found.data == 100
    assert found.degrees_of_freedom < 0.6 * Spline.through(np.arange(200.0), np.ones(200), 2, 2e3).degrees_of_freedom


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    order=st.integers(1, 4),
    strength=st.floats(0.01, 1e4),
    slope=st.lists(st.integers(-5, 5), min_size=4, max_size=4),
)
def test_a_polynomial_below_the_order_passes_through_and_the_cost_is_what_it_says(
    seed: int, order: int, strength: float, slope: list[int]
) -> None:
    rng = np.random.default_rng(seed)
    series, weights = rng.normal(size=30), rng.uniform(0.5, 2, 30) * (rng.random(30) < 0.8)
    weights[:5] = 1.0
    polynomial = np.polynomial.polynomial.polyval(np.linspace(-1, 1, 30), slope[:order])

    plain = Spline.through(series, weights, order, strength)
    moved = Spline.through(series + polynomial, weights, order, strength)

    np.testing.assert_allclose(moved.values, plain.values + polynomial, atol=1e-6)
    rough = np.sum((_differences(30, order) @ plain.values) ** 2)
    cost = np.sum(weights * (series - plain.values) ** 2) + strength * rough
    assert plain.cost == pytest.approx(float(cost), rel=1e-7)
    assert moved.cost == pytest.approx(plain.cost, rel=1e-5, abs=1e-8)


def test_the_weakest_smoothing_joins_the_data_by_lines_and_the_strongest_is_the_weighted_line() -> None:
    series, weights = np.array([0.0, 9.0, 9.0, 6.0, 2.0]), np.array([1.0, 0.0, 0.0, 2.0, 3.0])
    weak = Spline.through(series, weights, 1, 1e-9)
    np.testing.assert_allclose(weak.values, [0, 2, 4, 6, 2], atol=1e-6)
    flat = Spline.through(series, weights, 1, 1e9)
    np.testing.assert_allclose(flat.values, np.full(5, 18 / 6), atol=1e-6)
    line = Spline.through(series, weights, 2, 1e9)
    slope, start = np.polyfit([0, 3, 4], [0, 6, 2], 1, w=np.sqrt([1, 2, 3]))
    np.testing.assert_allclose(line.values, start + slope * np.arange(5), atol=1e-6)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_the_likelihood_over_gaps_is_that_of_contrasts_free_of_polynomials(order: int) -> None:
    """Contrasts of the data there are, orthogonal to polynomials: noise v / w, and v / strength times the walk's covariance."""
    rng = np.random.default_rng(order)
    size = 30
    series, weights = rng.normal(size=size), rng.uniform(0.5, 2, size)
    weights[[3, 10, 11, 12, 25]] = 0
    there = weights > 0
    walk = np.linalg.pinv(_differences(size, order))[there]
    contrasts = null_space(np.vander(np.linspace(-1, 1, size), order)[there].T).T

    def exact(strength: float, noise: float) -> float:
        covariance = noise * contrasts @ (np.diag(1 / weights[there]) + walk @ walk.T / strength) @ contrasts.T
        seen = contrasts @ series[there]
        return -float(np.linalg.slogdet(covariance)[1] + seen @ np.linalg.solve(covariance, seen)) / 2

    def ours(strength: float, noise: float) -> float:
        return Spline.through(series, weights, order, strength).log_likelihood(noise)

    for strength, noise in ((0.3, 0.5), (50.0, 1.7)):
        expected = exact(strength, noise) - exact(2.0, 1.0)
        assert ours(strength, noise) - ours(2.0, 1.0) == pytest.approx(expected, abs=1e-7)
