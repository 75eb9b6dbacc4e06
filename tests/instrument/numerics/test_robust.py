"""Noise by the median of steps."""

import numpy as np
import pytest

from instrument.numerics import step_noise


def test_the_noise_of_a_series_is_that_of_its_steps() -> None:
    """Normal noise of 3 on a line that rises by 0.01 a value, and a tenth of the values far off."""
    rng = np.random.default_rng(1)
    series = 3 * rng.standard_normal(20_000) + 0.01 * np.arange(20_000)
    assert step_noise(series) == pytest.approx(3.0, rel=0.02)
    series[::20] += 1e6
    assert step_noise(series) == pytest.approx(3.0, rel=0.15)


def test_steps_by_hand() -> None:
    """Steps of 1, 2 and 9: the median is 2, that of a normal deviate of variance 2 is 0.6745 sqrt 2."""
    assert step_noise(np.array([0.0, 1.0, 3.0, 12.0])) == pytest.approx(2 / (0.6745 * np.sqrt(2)))
    assert step_noise(np.array([5.0])) == np.inf
