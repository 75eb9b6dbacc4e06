"""A counter that is prolonged in its dead time by what it loses."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols import Integers
from sim_backends.bench.dead_time import paralyzable
from sim_backends.bench.noise import measure
from sim_backends.bench.noise_settings import PhotonNoise

T_S, TAU_S = 50e-6, 20e-9


def _counts(expected: float, duration_s: float = T_S, dead_time_s: float = TAU_S, n: int = 100_000) -> Integers:
    return paralyzable(np.full(n, expected), np.full(n, duration_s), dead_time_s, [1, 0])


def _one_by_one(expected: float, duration_s: float, dead_time_s: float, n: int) -> Integers:
    """Arrivals drawn one after the other, from well before the bin; those with none in the dead time before them count."""
    random = np.random.default_rng(7)
    counted = np.zeros(n, np.int64)
    for bin_ in range(n):
        arrivals = random.poisson(expected * (1 + 5 * dead_time_s / duration_s))
        time_s = np.sort(random.uniform(-5 * dead_time_s, duration_s, arrivals))
        alone = np.diff(time_s, prepend=-np.inf) >= dead_time_s
        counted[bin_] = int((alone & (time_s >= 0)).sum())
    return counted


@pytest.mark.parametrize("rate_hz", [1e6, 5e6, 20e6, 40e6, 50e6, 200e6])
def test_the_mean_is_n_exp_minus_n_tau(rate_hz: float) -> None:
    """At 5 million a second exp(-0.1) = 0.905; the most is 1 / (e tau), 18.4 million, at 50 million; then it falls."""
    mean = rate_hz * T_S * np.exp(-rate_hz * TAU_S)
    counts = _counts(rate_hz * T_S)
    assert counts.mean() == pytest.approx(mean, abs=5 * (mean / 100_000) ** 0.5)


def test_the_most_that_is_ever_counted_is_one_in_e_dead_times() -> None:
    assert _counts(50e6 * T_S).mean() / T_S == pytest.approx(1 / (math.e * TAU_S), rel=1e-3)


@pytest.mark.parametrize("busy", [0.01, 0.1, 0.5, 1.0, 3.0])
def test_the_variance_falls_by_two_dead_times_of_counts(busy: float) -> None:
    """Variance over mean 1 - 2 m tau, with m tau = busy exp(-busy): 0.98, 0.82, 0.39, 0.26 and 0.70."""
    counts = _counts(busy * T_S / TAU_S)
    assert counts.var() / counts.mean() == pytest.approx(1 - 2 * busy * np.exp(-busy), rel=0.03)


@pytest.mark.parametrize("busy", [0.2, 1.0])
def test_mean_and_variance_are_those_of_arrivals_one_by_one(busy: float) -> None:
    """Twenty dead times in a bin."""
    expected, n = busy * 20, 40_000
    truth, counts = _one_by_one(expected, 1.0, 0.05, n), _counts(expected, 1.0, 0.05)
    assert counts.mean() == pytest.approx(truth.mean(), abs=5 * (truth.var() / n) ** 0.5)
    assert counts.var() == pytest.approx(truth.var(), rel=0.06)


def test_a_dead_time_as_long_as_the_bin_leaves_one_count_at_most() -> None:
    counts = _counts(1.0, 1e-6, 1e-6)
    assert set(np.unique(counts)) == {0, 1}
    assert counts.mean() == pytest.approx(np.exp(-1.0), abs=0.008)


def test_without_dead_time_without_light_and_without_time() -> None:
    assert _counts(50.0, dead_time_s=0.0).var() == pytest.approx(50.0, rel=0.03)
    assert _counts(0.0).sum() == 0
    assert _counts(0.0, duration_s=0.0).sum() == 0
    assert _counts(1e9, n=10).sum() == 0  # blinded


def test_a_dead_time_of_next_to_nothing_leaves_all_photons() -> None:
    assert _counts(50.0, dead_time_s=1e-300).mean() == pytest.approx(50.0, abs=5 * (50 / 100_000) ** 0.5)


@given(busy=st.floats(0, 800), ratio=st.floats(1e-6, 3))
def test_any_dead_time_and_any_light_give_a_probability(busy: float, ratio: float) -> None:
    assert _counts(busy / ratio, 1.0, ratio, n=3).max() <= max(1, 1 / ratio)


def test_the_setting_chooses() -> None:
    """2,500 photons in 50 us: one in every dead time. 1 / (1 + 1) of them are left, or 1 / e."""
    light, n = np.full(2000, 2500.0), 2000
    left = {
        kind: measure(
            PhotonNoise(kind="poisson", dead_time_s=TAU_S, dead_time_kind=kind),
            0,
            light=light,
            lit_px=light,
            duration_s=np.full(n, T_S),
            counts_per_light=1.0,
        ).mean()
        for kind in ("non-paralyzable", "paralyzable")
    }
    assert left["non-paralyzable"] == pytest.approx(1250, rel=2e-3)
    assert left["paralyzable"] == pytest.approx(2500 / math.e, rel=2e-3)


@given(prefix=st.integers(1, 60))
def test_a_count_does_not_depend_on_the_bins_after_it(prefix: int) -> None:
    expected = np.linspace(1.0, 400.0, 64)
    changed = expected.copy()
    changed[prefix:] = 3.0
    before, after = (paralyzable(n, np.full(64, T_S), 1e-6, [9, 4])[:prefix].tolist() for n in (expected, changed))
    assert before == after
