"""The statistics of what the counter reads."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols import Floats, InputError, Integers
from sim_backends.bench.dead_time import non_paralyzable as count_photons
from sim_backends.bench.noise import measure
from sim_backends.bench.noise_settings import NoNoise, PhotonNoise, PixelNoise


def photons(expected: float, duration_s: float, dead_time_s: float, n: int = 100_000) -> Integers:
    return count_photons(np.full(n, expected), np.full(n, duration_s), dead_time_s, [1, 0])


def read(noise: NoNoise | PixelNoise | PhotonNoise, light: Floats, lit_px: float) -> Floats:
    same = np.full(len(light), lit_px)
    counts = measure(noise, 0, light=light, lit_px=same, duration_s=np.full(len(light), 50e-6), counts_per_light=2.0)
    return counts.astype(np.float64)


def test_without_noise_the_value_is_the_light() -> None:
    assert read(NoNoise(), np.array([1.25, 0.0, 7.5]), 3.0).tolist() == [1.25, 0.0, 7.5]


@pytest.mark.parametrize("lit_px", [1.0, 100.0, 8192.0])
def test_pixel_noise_is_sigma_times_the_root_of_the_lit_pixels(lit_px: float) -> None:
    values = read(PixelNoise(kind="pixel", sigma=0.1, seed=3), np.full(10_000, 5.0), lit_px)
    expected = 0.1 * np.sqrt(lit_px)  # 9.05 for half of 128 x 128
    assert values.std() == pytest.approx(expected, rel=0.03)
    assert values.mean() == pytest.approx(5.0, abs=4 * expected / 100)


def test_photons_without_dead_time_have_a_variance_equal_to_their_mean() -> None:
    counts = photons(50.0, 50e-6, 0.0)
    assert counts.mean() == pytest.approx(50.0, rel=0.005)
    assert counts.var() == pytest.approx(50.0, rel=0.03)


def test_twenty_nanoseconds_lose_a_tenth_at_five_million_counts_a_second() -> None:
    """The head's data sheet: 5e6 counted a second at 10 % loss, that is 5.556e6 arriving."""
    arriving = 5e6 / 0.9
    counts = photons(arriving * 1e-3, 1e-3, 20e-9, 20_000)
    assert counts.mean() / 1e-3 == pytest.approx(5e6, rel=1e-3)


@pytest.mark.parametrize("busy", [0.01, 0.05, 0.1, 0.5])
def test_dead_time_lowers_mean_and_variance_as_renewal_theory_says(busy: float) -> None:
    """Mean N / (1 + N tau / T); variance over mean 1 / (1 + N tau / T)^2."""
    dead_s, duration_s = 20e-9, 50e-6
    expected = busy * duration_s / dead_s
    counts = photons(expected, duration_s, dead_s)
    assert counts.mean() == pytest.approx(expected / (1 + busy), rel=5e-3)
    assert counts.var() / counts.mean() == pytest.approx(1 / (1 + busy) ** 2, rel=0.04)


def test_a_counter_that_is_dead_for_longer_than_the_bin_counts_one_at_most() -> None:
    counts = photons(3.0, 1e-6, 5e-6)
    assert set(np.unique(counts)) == {0, 1}
    assert counts.mean() == pytest.approx(1 - np.exp(-3.0), abs=0.005)


def test_two_dead_times_in_a_bin_give_the_probabilities_of_arrivals_one_by_one() -> None:
    """T = 2.5 tau: up to three counts. P(0) = exp(-N), P(at least 2) = P(two gaps within T - tau)."""
    rate, duration_s, dead_s = 2.0, 2.5, 1.0
    counts = photons(rate * duration_s, duration_s, dead_s)
    live = rate * (duration_s - dead_s)
    assert (counts == 0).mean() == pytest.approx(np.exp(-5.0), abs=0.002)
    assert (counts >= 2).mean() == pytest.approx(1 - np.exp(-live) * (1 + live), abs=0.006)
    assert counts.max() == 3


def test_a_saturated_counter_reads_one_count_a_dead_time() -> None:
    assert photons(1e9, 50e-6, 20e-9, 100).min() >= 2499
    assert photons(1e9, 50e-6, 20e-9, 100).max() <= 2501


def test_no_light_and_no_time_give_no_counts() -> None:
    assert photons(0.0, 50e-6, 20e-9, 10).sum() == 0
    assert photons(0.0, 0.0, 20e-9, 10).sum() == 0


def test_dark_counts_come_with_time_and_not_with_light() -> None:
    noise = PhotonNoise(kind="poisson", dark_rate_hz=600.0, seed=2)
    counts = read(noise, np.zeros(100_000), 0.0)
    assert counts.mean() == pytest.approx(0.03, rel=0.06)  # 600 a second in 50 us


def test_photon_counts_are_whole_numbers_of_32_bits() -> None:
    noise = PhotonNoise(kind="poisson")
    counts = measure(noise, 0, light=np.ones(3), lit_px=np.ones(3), duration_s=np.full(3, 1e-4), counts_per_light=250.0)
    assert counts.dtype == np.uint32


@given(prefix=st.integers(1, 60), dead_time_s=st.sampled_from([0.0, 20e-9, 1e-6]))
def test_a_count_does_not_depend_on_the_bins_after_it(prefix: int, dead_time_s: float) -> None:
    """What was handed over stays true when the object's further way changes."""
    expected = np.linspace(1.0, 400.0, 64)
    changed = expected.copy()
    changed[prefix:] = 3.0
    duration_s = np.full(64, 50e-6)
    before = count_photons(expected, duration_s, dead_time_s, [9, 4])
    after = count_photons(changed, duration_s, dead_time_s, [9, 4])
    assert before[:prefix].tolist() == after[:prefix].tolist()


@pytest.mark.parametrize("light", [2.0**31, 1e30, np.inf, np.nan])
def test_more_photons_than_32_bits_hold_are_refused(light: float) -> None:
    with pytest.raises(InputError, match="32 bits"):
        measure(
            PhotonNoise(kind="poisson"),
            0,
            light=np.array([1.0, light]),
            lit_px=np.ones(2),
            duration_s=np.full(2, 50e-6),
            counts_per_light=1.0,
        )
