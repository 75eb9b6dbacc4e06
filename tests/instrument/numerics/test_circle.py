"""A circle through points, exact ones and noisy ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.numerics import Circle, fit_circle
from protocols import Floats


def _arc(angles: Floats, radius: float = 2.0, centre: tuple[float, float] = (3.0, -1.0)) -> Floats:
    return np.asarray(centre + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1), np.float64)


def _fitted(points: Floats) -> Circle:
    circle = fit_circle(points)
    assert circle is not None
    return circle


def test_four_points_of_a_quarter_give_the_circle() -> None:
    circle = _fitted(_arc(np.linspace(0, np.pi / 2, 4)))
    np.testing.assert_allclose(circle.centre, [3, -1], atol=1e-9)
    assert circle.radius == pytest.approx(2.0, abs=1e-9)
    assert circle.scatter < 1e-9
    assert circle.turned_rad == pytest.approx(np.pi / 2)


@given(
    radius=st.floats(0.01, 100),
    x=st.floats(-100, 100),
    y=st.floats(-100, 100),
    first=st.floats(-4, 4),
    turn=st.floats(0.5, 12),
)
def test_any_arc_gives_its_circle_and_how_far_it_turned(
    radius: float, x: float, y: float, first: float, turn: float
) -> None:
    circle = _fitted(_arc(first + np.linspace(0, turn, 30), radius, (x, y)))
    np.testing.assert_allclose(circle.centre, [x, y], atol=1e-6 * (radius + abs(x) + abs(y)))
    assert circle.radius == pytest.approx(radius, rel=1e-5)
    assert circle.turned_rad == pytest.approx(turn, rel=1e-5)


def test_a_turn_there_and_back_counts_once() -> None:
    there = np.linspace(0, 2, 20)
    assert _fitted(_arc(np.concatenate([there, there[::-1]]))).turned_rad == pytest.approx(2.0)


@pytest.mark.parametrize("turn", [1.5, 2 * np.pi])
def test_the_stated_covariance_is_the_scatter_of_three_hundred_draws(turn: float) -> None:
    rng = np.random.default_rng(5)
    angles = np.linspace(0, turn, 60)
    fits = [_fitted(_arc(angles) + 0.03 * rng.standard_normal((60, 2))) for _ in range(300)]
    scatter = np.cov(np.stack([fit.centre for fit in fits]).T)
    stated = np.mean([fit.covariance for fit in fits], axis=0)
    np.testing.assert_allclose(np.diagonal(stated), np.diagonal(scatter), rtol=0.2)
    assert stated[0, 1] == pytest.approx(scatter[0, 1], abs=0.2 * float(np.sqrt(scatter[0, 0] * scatter[1, 1])))
    assert np.mean([fit.scatter for fit in fits]) == pytest.approx(0.03, rel=0.03)
    leverage = fits[0].leverage * 0.03**2 / 60  # white noise of 60 places, each with one point
    np.testing.assert_allclose(np.diagonal(leverage), np.diagonal(scatter), rtol=0.3)


def test_a_whole_circle_of_n_points_has_two_nths_of_their_variance() -> None:
    """The information on one coordinate of the centre is the sum of cos^2 of the angles, n / 2."""
    circle = _fitted(_arc(2 * np.pi * np.arange(50) / 50))
    np.testing.assert_allclose(circle.leverage, 2 * np.eye(2), atol=1e-6)


def test_points_that_deviate_alike_say_less() -> None:
    """Each of 40 deviations ten times over: a tenth of the points, ten times the covariance."""
    angles = np.linspace(0, 2 * np.pi, 400)
    rng = np.random.default_rng(6)
    white = _fitted(_arc(angles) + 0.03 * rng.standard_normal((400, 2)))
    alike = _fitted(_arc(angles) + 0.03 * rng.standard_normal((40, 2)).repeat(10, axis=0))
    assert 5 < alike.covariance.trace() / white.covariance.trace() < 15


def test_three_points_or_a_line_make_no_circle() -> None:
    assert fit_circle(_arc(np.array([0.0, 1.0, 2.0]))) is None
    assert fit_circle(np.stack([np.arange(20.0), 2 * np.arange(20.0) + 1], axis=1)) is None
    assert fit_circle(np.ones((10, 2))) is None
