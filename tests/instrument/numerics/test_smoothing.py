"""The smoothing spline, against the dense formula and against series of known roughness."""

import numpy as np
import pytest

from instrument.numerics.smoothing import smooth
from instrument.numerics.spline import Spline
from protocols import Floats


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_values_and_variances_are_those_of_the_dense_normal_equations(order: int) -> None:
    rng = np.random.default_rng(order)
    size = 60
    series = np.cumsum(rng.normal(size=size)) + rng.normal(size=size)
    weights = rng.uniform(0.5, 2, size)
    weights[20:25] = 0
    difference = np.diff(np.eye(size), order, axis=0)
    inverse = np.asarray(np.linalg.inv(np.diag(weights) + 30 * difference.T @ difference), np.float64)

    found = Spline.through(series, weights, order, 30.0)

    values: Floats = inverse @ (weights * series)
    np.testing.assert_allclose(found.values, values, atol=1e-9)
    expected = inverse.diagonal() + inverse[0, 0] - 2 * inverse[0]
    np.testing.assert_allclose(found.variances_to(0, np.arange(size)), expected, atol=1e-9)
    to_another = inverse.diagonal() + inverse[17, 17] - 2 * inverse[17]
    np.testing.assert_allclose(found.variances_to(17, np.arange(size)), to_another, atol=1e-9)
    np.testing.assert_allclose(np.diag(found.covariance_to(17, np.arange(size))), to_another, atol=1e-9)
    assert found.cost == pytest.approx(float(series @ (weights * (series - values))))


@pytest.mark.parametrize("order", [1, 2, 3])
def test_the_likelihood_is_that_of_the_differences(order: int) -> None:
    """Of order p and noise v: p-th differences of the data are normal, of covariance v D D' + (v / strength) 1."""
    series = np.random.default_rng(order).normal(size=40)
    difference = np.diff(np.eye(40), order, axis=0)

    def exact(strength: float, noise: float) -> float:
        covariance = noise * (difference @ difference.T + np.eye(40 - order) / strength)
        seen = difference @ series
        return -float(np.linalg.slogdet(covariance)[1] + seen @ np.linalg.solve(covariance, seen)) / 2

    def ours(strength: float, noise: float) -> float:
        return Spline.through(series, np.ones(40), order, strength).log_likelihood(noise)

    for strength, noise in ((0.5, 0.7), (30.0, 1.3), (1000.0, 1.0)):
        assert ours(strength, noise) - ours(2.0, 1.0) == pytest.approx(
            exact(strength, noise) - exact(2.0, 1.0), abs=1e-8
        )


@pytest.mark.parametrize("size", [100, 1666, 13_000])
def test_the_strongest_smoothing_of_order_3_is_a_parabola(size: int) -> None:
    """To 0.0001 px, however long; and its errors are those of three unknowns, here of the last value minus the first."""
    time = np.linspace(-1, 1, size)
    parabola = 70 * time + 30 * time**2
    found = Spline.through(parabola, np.ones(size), 3, 100 * (size / (2 * np.pi)) ** 6)

    np.testing.assert_allclose(found.values, parabola, atol=1e-4)
    base = np.stack([np.ones(size), time, time**2], axis=1)
    step = base[-1] - base[0]
    assert found.variances_to(0, np.array([size - 1]))[0] == pytest.approx(
        float(step @ np.asarray(np.linalg.solve(base.T @ base, step), np.float64)), rel=0.05
    )


@pytest.mark.parametrize("order", [1, 2, 3])
def test_noise_and_roughness_are_found_again(order: int) -> None:
    """A p-fold random walk of steps 0.02 under noise 0.5."""
    rng = np.random.default_rng(10 + order)

    found = smooth(_walk(rng, order, 4000, 0.02) + 0.5 * rng.normal(size=4000), np.ones(4000), orders=(order,))

    assert abs(found.noise_variance / 0.25 - 1) < 0.1
    strengths = np.log10([spline.strength for spline in found.splines])
    assert abs(float(np.average(strengths, weights=found.probabilities)) - np.log10(0.25 / 0.02**2)) < 0.5


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


def test_of_orders_equally_good_the_stiffest_is_taken() -> None:
    """A parabola under noise needs no more than order 3, a curve of changing acceleration needs order 4."""
    time = np.linspace(0, 1, 1666)
    noise = np.random.default_rng(3).normal(size=1666)

    parabola = smooth(40 * time + 20 * time**2 + noise, np.ones(1666))
    turn = smooth(45 * np.sin(np.pi / 2 * time) + 0.3 * noise, np.ones(1666))

    assert parabola.order == 3
    assert parabola.degrees_of_freedom < 4
    assert turn.order == 4
    assert turn.degrees_of_freedom < 6.5


def test_a_fast_oscillation_is_followed_where_the_noise_is_known_to_be_small() -> None:
    rng = np.random.default_rng(0)
    truth = np.sin(2 * np.pi * np.arange(1666) / 8.33)
    series = truth + 0.3 * rng.normal(size=1666)

    found = smooth(series, np.full(1666, 1 / 0.09), absolute_weights=True)

    assert float(((found.values - truth) ** 2).mean()) < 0.06


def test_what_stands_in_a_gap_does_not_count() -> None:
    rng = np.random.default_rng(0)
    series = np.cumsum(rng.normal(size=200))
    weights = np.ones(200)
    weights[50:60] = 0
    other = series.copy()
    other[50:60] = 1e9

    np.testing.assert_array_equal(smooth(series, weights).values, smooth(other, weights).values)


def test_the_prior_precision_of_a_parabola_is_that_of_its_second_differences() -> None:
    """k^2 / 2 has the second difference 1 at each of 38 places, and a line has none: 38 times strength over noise."""
    rng = np.random.default_rng(4)
    steps = np.arange(40.0)
    fit = smooth(steps + rng.standard_normal(40), np.ones(40), orders=(2,))
    weights = np.array(fit.probabilities)
    strength = np.prod(np.array([spline.strength for spline in fit.splines]) ** weights)
    basis = np.stack([steps, steps**2 / 2], axis=1)
    expected = [[0, 0], [0, 38 * strength / fit.noise_variance]]
    np.testing.assert_allclose(fit.precision_of(basis), expected, rtol=1e-9, atol=1e-6 * strength)
