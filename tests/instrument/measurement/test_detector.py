"""Counts into light."""

from dataclasses import replace

import numpy as np
import pytest

from instrument.measurement import light_of
from instrument.plan import Plan
from instrument.recording import Recording
from protocols import Floats, InputError

WEIGHTS = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 1.0])


def _recording(values: Floats, *, photon_counts: bool) -> Recording:
    return Recording(
        plan=Plan(frames=max(3, len(values))),
        values=values,
        frame_valid=np.ones(len(values), np.bool_),
        picture_time_s=50e-6,
        photon_counts=photon_counts,
    )


def test_dead_time_and_dark_counts_by_hand() -> None:
    """250 counts in 50 us at 20 ns: dead for 10 %, so 250 / 0.9; 40,000 dark counts a second are 2 a pattern."""
    recording = replace(_recording(np.full((1, 6), 250.0), photon_counts=True), dead_time_s=20e-9, dark_rate_hz=40e3)

    values, variance = light_of(recording, WEIGHTS)

    np.testing.assert_allclose(values, 250 / 0.9 - 2)
    np.testing.assert_allclose(variance, 250 / 0.9**2)


def test_a_background_is_taken_off_as_light_and_not_as_counts() -> None:
    """250 counts are 250 / 0.9, 125 behind them 125 / 0.95: the difference is 146.2, where that of the counts would be 125."""
    recording = replace(_recording(np.full((2, 6), 250.0), photon_counts=True), dead_time_s=20e-9, dark_rate_hz=40e3)
    behind = replace(recording, values=np.full((3, 6), 125.0), frame_valid=np.array([True, False, True]))

    alone = recording.minus(behind)
    values, variance = light_of(alone, WEIGHTS)

    np.testing.assert_allclose(values, 250 / 0.9 - 125 / 0.95)
    np.testing.assert_allclose(variance, 250 / 0.9**2 + 125 / 0.95**2)
    assert alone.frame_valid.tolist() == [True, False]
    assert alone.first(1).background is not None
    assert light_of(alone.first(1), WEIGHTS)[0].shape == (1, 6)


def test_a_background_of_another_detector_or_a_second_one_is_refused() -> None:
    recording = _recording(np.full((2, 6), 250.0), photon_counts=True)
    with pytest.raises(InputError, match="one recording of photon counts and one of none"):
        recording.minus(replace(recording, photon_counts=False))
    with pytest.raises(InputError, match="a second background"):
        recording.minus(recording).minus(recording)


def test_the_stated_variance_is_that_of_a_simulated_counter_with_dead_time() -> None:
    """Arrivals at 400 in 50 us, each followed by 30 ns of blindness: counted one by one."""
    rng = np.random.default_rng(2)
    tau, span, rate = 30e-9, 50e-6, 8e6
    # Time from count to count is the dead time plus an exponential wait.
    counts = (np.cumsum(tau + rng.exponential(1 / rate, (6000, 600)), axis=1) < span).sum(axis=1).astype(np.float64)
    recording = replace(_recording(counts.reshape(1000, 6), photon_counts=True), dead_time_s=tau)

    values, variance = light_of(recording, WEIGHTS)

    assert abs(values.mean() / 400 - 1) < 0.003
    assert abs(variance.mean() / values.var() - 1) < 0.06


def test_an_empty_bin_is_no_certainty() -> None:
    values, variance = light_of(_recording(np.zeros((1, 6)), photon_counts=True), WEIGHTS)

    assert values.tolist() == [[0.0] * 6]
    assert variance.tolist() == [[1.0] * 6]


def test_more_counts_than_the_dead_time_allows_are_refused() -> None:
    recording = replace(_recording(np.full((1, 6), 2600.0), photon_counts=True), dead_time_s=20e-9)

    with pytest.raises(InputError, match="fewer than 2500, as the dead time is 20 ns"):
        light_of(recording, WEIGHTS)


def test_another_detectors_noise_is_read_off_the_total_light_whatever_its_drift_and_outliers() -> None:
    rng = np.random.default_rng(3)
    values = 400 + rng.normal(size=(4000, 6)) * 3 + np.linspace(0, 200, 4000)[:, None]
    values[1000] = np.nan
    values[2000] = 1e6

    same, variance = light_of(_recording(values, photon_counts=False), WEIGHTS)

    np.testing.assert_array_equal(same, values)
    assert variance.shape == values.shape
    assert abs(variance[0, 0] / 9 - 1) < 0.07


def test_noise_of_two_frames_is_unknown() -> None:
    _, variance = light_of(_recording(np.ones((2, 6)), photon_counts=False), WEIGHTS)

    assert np.isinf(variance).all()
