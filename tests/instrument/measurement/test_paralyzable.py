"""A detector whose dead time every photon prolongs."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.config import LightTable
from instrument.measurement import Detector, light_of
from instrument.plan import Plan
from instrument.recording import Recording
from protocols import Floats, InputError

SPAN_S, TAU_S = 50e-6, 20e-9
PARALYZABLE = Detector(SPAN_S, TAU_S, dead_time_kind="paralyzable")


def _counts(light: Floats | float) -> Floats:
    return np.asarray(light * np.exp(-np.asarray(light) * TAU_S / SPAN_S), np.float64)


def test_a_thousand_photons_by_hand() -> None:
    """N tau / T = 0.4: 1000 exp(-0.4) = 670.32 counts, of variance 670.32 (1 - 0.26813 (2 - 0.0004)), over (0.6 exp(-0.4))^2."""
    light, variance = PARALYZABLE.light(np.array([1000 * np.exp(-0.4)]))
    assert light[0] == pytest.approx(1000.0, rel=1e-9)
    assert variance[0] == pytest.approx(670.320046 * (1 - 0.268128018 * 1.9996) / (0.6 * 0.670320046) ** 2, rel=1e-6)


@given(light=st.floats(0.0, 2250.0), dark=st.floats(0, 1e5))
def test_light_up_to_nine_tenths_of_the_turning_point_is_found(light: float, dark: float) -> None:
    """Counts rise up to N = T / tau = 2,500."""
    found, _ = replace(PARALYZABLE, dark_rate_hz=dark).light(np.array([_counts(light)]))
    assert found[0] == pytest.approx(light - dark * SPAN_S, abs=1e-6)


def test_nan_stays_nan_and_an_empty_bin_is_no_certainty() -> None:
    light, variance = PARALYZABLE.light(np.array([np.nan, 0.0]))
    assert np.isnan(light[0])
    assert light[1] == 0
    assert variance[1] == pytest.approx(1.0)


def test_counts_beyond_the_largest_are_taken_as_chance_up_to_six_standard_deviations() -> None:
    """T / (e tau) = 919.7 counts at most, and 6 sqrt(919.7) = 182 beyond by chance."""
    light, variance = PARALYZABLE.light(np.array([919.0, 1101.0]))
    assert np.isfinite(light).all()
    assert light.max() < 2500
    assert (variance > 1e4).all()
    with pytest.raises(InputError, match=r"1102 counts in a pattern of 50 us; expected at most 919\.699, as a paralyz"):
        PARALYZABLE.light(np.array([1102.0]))


@pytest.mark.parametrize("mean", [200.0, 800.0, 1500.0])
def test_the_stated_variance_is_that_of_arrivals_counted_one_by_one(mean: float) -> None:
    """A photon counts if none came within the dead time before it, in a detector that has been lit for long."""
    rng = np.random.default_rng(4)
    counts = np.empty(3000)
    for k in range(len(counts)):
        lead = 20 * TAU_S
        arrivals = np.sort(rng.uniform(-lead, SPAN_S, rng.poisson(mean * (1 + lead / SPAN_S))))
        free = np.diff(arrivals, prepend=-np.inf) > TAU_S
        counts[k] = np.count_nonzero(free & (arrivals >= 0))
    light, variance = PARALYZABLE.light(counts)
    assert light.mean() == pytest.approx(mean, rel=0.01)
    assert variance.mean() == pytest.approx(light.var(), rel=0.1)


def test_without_dead_time_the_kind_does_not_matter() -> None:
    counts = np.array([0.0, 7.0, 300.0])
    for kind in ("paralyzable", "non-paralyzable"):
        assert Detector(SPAN_S, 0.0, dead_time_kind=kind).light(counts)[0].tolist() == [0.0, 7.0, 300.0]


def test_a_recording_is_read_as_its_light_table_says() -> None:
    """670.32 counts are 1,000 photons where the dead time is prolonged, and 915.8 where it is not."""
    counts = np.full((10, 6), _counts(1000.0))
    recording = Recording(
        Plan(frames=10, image_size=16), counts, np.ones(10, np.bool_), SPAN_S, photon_counts=True, dead_time_s=TAU_S
    )
    long = replace(recording, light=LightTable(dead_time_kind="paralyzable"))
    weights = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 1.0])
    np.testing.assert_allclose(light_of(long, weights)[0], 1000.0)
    np.testing.assert_allclose(light_of(recording, weights)[0], 670.320046 / (1 - 0.268128018))
