"""The smoothing spline, against the dense formula and against series of known roughness."""

import numpy as np
import pytest

from instrument.tracking.smoothing import smooth
from protocols import Floats


@pytest.mark.parametrize("order", [1, 2, 3])
def test_values_and_variances_are_those_of_the_dense_normal_equations(order: int) -> None:
    rng = np.random.default_rng(order)
    size = 60
    series = np.cumsum(rng.normal(size=size)) + rng.normal(size=size)
    weights = rng.uniform(0.5, 2, size)
    weights[20:25] = 0
    weights /= weights[weights > 0].mean()

    found = smooth(series, weights, orders=(order,))

    difference = np.diff(np.eye(size), order, axis=0)
    matrix = np.diag(weights) + found.strength * difference.T @ difference
    base = np.asarray(np.vander(np.linspace(-1, 1, size), 4), np.float64)
    normal = np.asarray(base @ np.linalg.inv(base.T @ (weights[:, None] * base)) @ base.T, np.float64)
    cubic: Floats = normal @ (weights * series)
    inverse = np.asarray(np.linalg.inv(matrix), np.float64)
    np.testing.assert_allclose(found.values, cubic + inverse @ (weights * (series - cubic)), atol=1e-8)
    covariance: Floats = found.noise_variance * (inverse + normal)
    expected = covariance.diagonal() + covariance[0, 0] - 2 * covariance[0]
    np.testing.assert_allclose(found.variance_to_first, expected, atol=1e-8)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_noise_and_roughness_are_found_again(order: int) -> None:
    """A p-fold random walk of steps 0.02 under noise 0.5."""
    rng = np.random.default_rng(10 + order)

    found = smooth(_walk(rng, order, 4000, 0.02) + 0.5 * rng.normal(size=4000), np.ones(4000), orders=(order,))

    assert abs(found.noise_variance / 0.25 - 1) < 0.1
    assert abs(np.log10(found.strength / (0.25 / 0.02**2))) < 0.5


@pytest.mark.parametrize("order", [1, 2, 3])
def test_stated_errors_against_the_first_value_cover_95_percent(order: int) -> None:
    rng = np.random.default_rng(20 + order)
    inside: list[float] = []
    # Steps of a fifth of the noise: enough to tell the strength from 300 data.
    for _ in range(60):
        truth = _walk(rng, order, 300, 0.1)
        found = smooth(truth + 0.5 * rng.normal(size=300), np.ones(300), orders=(order,))
        error = found.values - truth
        inside.append(float((np.abs(error - error[0]) <= 1.96 * np.sqrt(found.variance_to_first)).mean()))

    assert 0.90 < np.mean(inside) < 0.99


def _walk(rng: np.random.Generator, order: int, size: int, step: float) -> Floats:
    steps = rng.normal(size=size) * step
    for _ in range(order):
        steps = np.cumsum(steps)
    return steps


def test_a_cubic_is_left_as_it_is() -> None:
    time = np.linspace(0, 1, 500)
    series = 3 - 40 * time + 80 * time**2 - 30 * time**3

    np.testing.assert_allclose(smooth(series, np.ones(500)).values, series, atol=1e-6)


def test_a_fast_oscillation_is_followed_where_the_noise_is_known_to_be_small() -> None:
    rng = np.random.default_rng(0)
    truth = np.sin(2 * np.pi * np.arange(1666) / 8.33)
    series = truth + 0.3 * rng.normal(size=1666)

    found = smooth(series, np.full(1666, 1 / 0.09), known=True)

    assert float(((found.values - truth) ** 2).mean()) < 0.06


def test_what_stands_in_a_gap_does_not_count() -> None:
    rng = np.random.default_rng(0)
    series = np.cumsum(rng.normal(size=200))
    weights = np.ones(200)
    weights[50:60] = 0
    other = series.copy()
    other[50:60] = 1e9

    np.testing.assert_array_equal(smooth(series, weights).values, smooth(other, weights).values)
