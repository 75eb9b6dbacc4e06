"""Variances and totals of a few frames, worked out by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.measurement import Measurement, noise_variance
from instrument.measurement.detector import Detector
from instrument.plan import Plan
from instrument.recording import Recording
from protocols import Floats, InputError

BOTH = np.array([1.0, 1.0])


def _recording(values: Floats, *, photon_counts: bool = False) -> Recording:
    valid = np.ones(len(values), np.bool_)
    return Recording(Plan(frames=len(values), image_size=16), values, valid, 50e-6, photon_counts=photon_counts)


# The detector


def test_dark_counts_are_taken_off_after_the_dead_time_and_may_leave_less_than_nothing() -> None:
    """No count in 50 us at 40,000 dark counts a second: -2, with the variance of one count."""
    light, variance = Detector(50e-6, 20e-9, 40e3).light(np.array([0.0]))
    assert (light.tolist(), variance.tolist()) == ([-2.0], [1.0])


def test_a_detector_without_faults_counts_every_photon_and_nothing_else() -> None:
    """No dead time and no dark counts unless they are stated: 100 counts are 100 photons, with the variance 100."""
    light, variance = Detector(50e-6).light(np.array([100.0]))
    assert (light.tolist(), variance.tolist()) == ([100.0], [100.0])


def test_what_was_not_measured_stays_unknown_beside_what_was() -> None:
    """500 counts in 50 us at 20 ns: dead for 20 %, so 625, with the variance 625 / 0.8."""
    light, variance = Detector(50e-6, 20e-9).light(np.array([[np.nan, 500.0]]))
    np.testing.assert_allclose(light, [[np.nan, 625.0]])
    np.testing.assert_allclose(variance[0, 1], 781.25)


def test_as_many_counts_as_dead_times_in_a_pattern_are_too_many_and_one_less_is_not() -> None:
    """50 us hold 2500 dead times of 20 ns. At 2499 the counter is live for 1/2500: 2499 * 2500 photons."""
    detector = Detector(50e-6, 20e-9)
    assert float(detector.light(np.array([2499.0]))[0][0]) == pytest.approx(2499 * 2500, rel=1e-9)
    with pytest.raises(InputError, match="2501 counts in a pattern of 50 us"):
        detector.light(np.array([10.0, 2501.0]))


@given(rate=st.floats(1, 1e7), dead_s=st.floats(1e-9, 90e-9), dark_hz=st.floats(0, 1e5))
def test_the_correction_undoes_a_dead_time(rate: float, dead_s: float, dark_hz: float) -> None:
    """Photons and dark counts arriving at ``rate`` and ``dark_hz`` are counted at r / (1 + r tau) [Knoll, chapter 4]."""
    arriving = rate + dark_hz
    counted = np.array([50e-6 * arriving / (1 + arriving * dead_s)])
    light, _ = Detector(50e-6, dead_s, dark_hz).light(counted)
    assert float(light[0]) == pytest.approx(50e-6 * rate, rel=1e-9, abs=1e-9)


# Noise of other detectors


def test_the_noise_of_four_frames_by_hand() -> None:
    """Totals 10, 12, 9, 13: changes 2, 3, 4, median 3. A standard deviation of 1.4826 * 3, over 2 (1 + 1) of the variance."""
    values = np.array([[4.0, 6.0], [7.0, 5.0], [4.0, 5.0], [6.0, 7.0]])
    assert noise_variance(values, BOTH, np.ones(4, np.bool_)) == pytest.approx((1.4826 * 3) ** 2 / 4)


def test_frames_that_are_not_valid_or_not_numbers_are_left_out_of_the_noise() -> None:
    """Totals 10, 12, 9, 13 remain of six frames."""
    totals = np.array([10.0, 1e9, 12.0, 9.0, np.nan, 13.0])
    values = np.stack([totals / 2, totals / 2], axis=1)
    valid = np.array([True, False, True, True, True, True])
    assert noise_variance(values, BOTH, valid) == pytest.approx((1.4826 * 3) ** 2 / 4)


def test_three_frames_are_the_fewest_whose_noise_is_known() -> None:
    """Totals 10, 12, 10 change by 2 twice."""
    values = np.array([[5.0, 5.0], [6.0, 6.0], [5.0, 5.0]])
    assert noise_variance(values, BOTH, np.ones(3, np.bool_)) == pytest.approx((1.4826 * 2) ** 2 / 4)
    assert np.isinf(noise_variance(values, BOTH, np.array([True, True, False])))


@given(gain=st.floats(0.1, 10), seed=st.integers(0, 1000))
def test_noise_grows_with_the_square_of_the_gain_and_does_not_see_an_offset(gain: float, seed: int) -> None:
    values = np.random.default_rng(seed).standard_normal((20, 2))
    valid = np.ones(20, np.bool_)
    weights = np.array([0.5, 2.0])
    once = noise_variance(values, weights, valid)
    assert noise_variance(gain * values + 100.0, weights, valid) == pytest.approx(gain**2 * once, rel=1e-6)
    assert noise_variance(values, gain * weights, valid) == pytest.approx(once, rel=1e-6)


# The measurement


def test_every_value_of_a_detector_that_counts_no_photons_has_the_same_variance() -> None:
    """H+ and H- of 5 and 5, 6 and 6, 5 and 5: the total changes by 2, twice; fringes do not count."""
    values = np.zeros((3, 6))
    values[:, :4] = np.random.default_rng(0).random((3, 4))
    values[:, 4] = values[:, 5] = [5.0, 6.0, 5.0]
    measured = Measurement.of(_recording(values))
    assert measured.total.tolist() == [10.0, 12.0, 10.0]
    np.testing.assert_allclose(measured.variance, (1.4826 * 2) ** 2 / 4)


def test_darkness_does_not_change() -> None:
    assert Measurement.of(_recording(np.zeros((20, 6)))).light_change() == 0.0


def test_a_change_to_more_light_counts_as_one_to_less_does() -> None:
    """Two of ten tenths are half as bright again: 1.5 / 1 - 1. Two that are a fifth as bright: 0.8."""
    values = np.full((100, 6), 50.0)
    values[20:40] = 75.0
    assert Measurement.of(_recording(values)).light_change() == pytest.approx(0.5)
    values[20:40] = 10.0
    assert Measurement.of(_recording(values)).light_change() == pytest.approx(0.8)


@pytest.mark.parametrize("flicker", [False, True])
def test_the_steady_total_is_the_total_where_position_flickers_with_it(*, flicker: bool) -> None:
    """H+ alternates by 10 of 50. Fringes that do so in proportion show a lamp, and the total stays; others show noise."""
    values = np.full((40, 6), 50.0)
    values[::2, 4] += 10.0
    if flicker:
        values[::2, :4] *= 110 / 100
    measured = Measurement.of(_recording(values))
    assert np.ptp(measured.total) == pytest.approx(10.0)
    if flicker:
        np.testing.assert_allclose(measured.steady_total, measured.total, rtol=1e-3)
    else:
        assert np.ptp(measured.steady_total[5:-5]) < 1.0


def test_position_that_flickers_twice_as_much_or_the_other_way_is_all_lamp_or_none() -> None:
    """The share of flicker is from 0 to 1: fringes that change by 20 % keep the total as it is, by -10 % make it smooth."""
    for part, kept in ((1.2, 1.0), (0.9, 0.0)):
        values = np.full((40, 6), 50.0)
        values[::2, 4] += 10.0
        values[::2, :4] *= part
        measured = Measurement.of(_recording(values))
        assert np.ptp(measured.steady_total[5:-5]) == pytest.approx(10.0 * kept, abs=1.0)


def test_image_values_of_photons_take_the_darkest_counts_at_one_count_of_variance() -> None:
    """Three empty frames: every value has the variance 1, and a difference 2."""
    found = Measurement.of(_recording(np.zeros((3, 6)), photon_counts=True)).image_values(steady_object=True)
    assert found.difference_variance.tolist() == [2.0, 2.0, 2.0]
    assert found.fixed_variance.tolist() == [[1.0] * 4] * 3
    assert found.noise == 1.0
    assert (len(found), found.size, found.difference.tolist()) == (3, 16, [0.0, 0.0, 0.0])
