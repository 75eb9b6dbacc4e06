"""One measurement of a recording: its mask, its total light, what it says of the image."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from instrument.measurement import Measurement, noise_variance
from instrument.plan import Plan
from instrument.recording import Recording
from protocols import Floats, InputError
from tests.support.plans import plan_of


def _recording(values: Floats, **more: Any) -> Recording:
    return replace(
        Recording(
            plan=Plan(frames=len(values), image_size=16),
            values=values,
            frame_valid=np.ones(len(values), np.bool_),
            picture_time_s=50e-6,
        ),
        **more,
    )


def _steady(frames: int, noise: float = 0.0, seed: int = 0) -> Floats:
    """Total light 100, half of it in each Fourier pattern."""
    rng = np.random.default_rng(seed)
    return np.full((frames, 6), 50.0) + noise * rng.standard_normal((frames, 6))


def test_a_frame_is_valid_if_it_is_trusted_and_all_its_values_are_numbers() -> None:
    values = _steady(4)
    values[1, 3] = np.nan
    measured = Measurement.of(_recording(values, frame_valid=np.array([True, True, False, True])))
    assert measured.valid.tolist() == [True, False, False, True]
    assert measured.total.tolist() == [100.0, 0.0, 0.0, 100.0]


def test_a_measurement_is_given_back_as_it_is() -> None:
    measured = Measurement.of(_recording(_steady(4)))
    assert Measurement.of(measured) is measured


def test_something_else_than_a_recording_is_refused_with_the_way_out() -> None:
    with pytest.raises(
        InputError, match=r"saw a str; expected a recording. To do: open the file first: open_recording"
    ):
        Measurement.of("run.h5")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]


def test_noise_of_the_total_is_smoothed_away_and_flicker_of_the_lamp_is_not() -> None:
    """Noise of 1 on each value is 1.41 on the total; a lamp that flickers by 5 % changes all values alike."""
    noisy = Measurement.of(_recording(_steady(2000, noise=1.0)))
    assert noisy.total.std() == pytest.approx(np.sqrt(2), rel=0.05)
    assert noisy.steady_total.std() < 0.2

    lamp = 1 + 0.05 * np.random.default_rng(1).standard_normal(2000)
    flickering = Measurement.of(_recording(_steady(2000, noise=0.1) * lamp[:, None]))
    assert np.abs(flickering.steady_total - 100 * lamp).std() < 0.3
    assert flickering.total.std() == pytest.approx(5.0, rel=0.05)


def test_light_change_is_the_largest_over_tenths_of_the_run() -> None:
    """From 100 to 80 in a straight line: the first tenth is 99, the last 81, the median 90."""
    values = _steady(1000) * np.linspace(1.0, 0.8, 1000)[:, None]
    assert Measurement.of(_recording(values)).light_change() == pytest.approx(0.1, abs=0.001)


def test_image_values_are_divided_by_the_lamp_where_the_object_stays_in_the_field() -> None:
    values = _steady(200)
    values[:, 4], values[:, 5] = 70.0, 30.0
    lamp = np.linspace(1.2, 0.8, 200)
    measured = Measurement.of(_recording(values * lamp[:, None]))
    steady = measured.image_values(steady_object=True)
    np.testing.assert_allclose(steady.difference, 40.0, rtol=0.01)
    np.testing.assert_allclose(steady.fixed, 50.0, rtol=0.01)
    moving = measured.image_values(steady_object=False)
    np.testing.assert_allclose(moving.difference, 40.0 * lamp)


def test_image_values_know_frame_pattern_and_time_of_each_row() -> None:
    """Frame 2 is masked: row 2 is frame 3, whose H+ is in its middle 4.5 patterns after the frame began."""
    values = _steady(5)
    values[2] = np.nan
    found = Measurement.of(_recording(values)).image_values(steady_object=True)
    assert found.frame.tolist() == [0, 1, 3, 4]
    assert found.pairs.tolist() == [[0, 0], [0, 1], [0, 2], [1, 1]]
    np.testing.assert_allclose(found.time_s[2] / 50e-6, [18 + 4.5, 18 + 5.5, 18 + 0.5, 18 + 1.5, 18 + 2.5, 18 + 3.5])


def test_photons_of_a_pair_share_the_variance_of_their_sum() -> None:
    counts = np.random.default_rng(0).poisson(50.0, (400, 6)).astype(np.float64)
    found = Measurement.of(_recording(counts, photon_counts=True)).image_values(steady_object=True)
    assert found.difference_variance == pytest.approx(100.0, rel=0.05)
    assert found.photon_counts


def test_the_noise_of_a_value_is_read_off_the_total_with_its_weights() -> None:
    """Total of six values times 1/3: a jump has twice 6/9 of a value's variance."""
    values = 40 + 3 * np.random.default_rng(5).standard_normal((200_000, 6))
    valid = np.ones(200_000, np.bool_)
    for weights in (np.full(6, 1 / 3), np.array([0.0, 0.0, 0.0, 0.0, 1.0, 1.0])):
        assert noise_variance(values, weights, valid) == pytest.approx(9.0, rel=0.03)


def test_darkness_is_no_light_to_follow() -> None:
    noise = np.random.default_rng(2).standard_normal((400, 6))
    with pytest.raises(InputError, match="light well above the noise"):
        Measurement.of(_recording(noise)).observe(steady=False)


def test_the_lamp_is_divided_out_however_dim_its_light_is() -> None:
    """Values in units of which the whole field has a hundredth."""
    values = 1e-4 * _steady(200)
    values[:, 4], values[:, 5] = 70e-4, 30e-4
    lamp = np.linspace(1.2, 0.8, 200)
    dim = Measurement.of(_recording(values * lamp[:, None])).image_values(steady_object=True)
    np.testing.assert_allclose(dim.difference, 40e-4, rtol=0.01)


def test_of_seven_frames_nothing_is_smoothed_and_of_eight_it_is() -> None:
    """Counts of H+ and H- of 30 and 90 in turn: each pair has the variance 60, unless neighbours are averaged."""
    counts = np.full((8, 6), 50.0)
    counts[0::2, 4:], counts[1::2, 4:] = 30.0, 90.0
    few = Measurement.of(_recording(counts[:7], photon_counts=True)).image_values(steady_object=True)
    assert few.difference_variance.tolist() == [60, 180, 60, 180, 60, 180, 60]
    more = Measurement.of(_recording(counts, photon_counts=True)).image_values(steady_object=True)
    assert np.ptp(more.difference_variance) < 60


def test_the_noise_of_photons_is_that_of_their_number() -> None:
    """Six values of 50 counts each, H+ and H- of 30 and 70: the mean variance is 50, whatever the pair's halves."""
    counts = np.full((40, 6), 50.0)
    counts[:, 4], counts[:, 5] = 30.0, 70.0
    found = Measurement.of(_recording(counts, photon_counts=True)).image_values(steady_object=True)
    assert found.noise == pytest.approx(np.sqrt(50.0))
    np.testing.assert_allclose(found.difference_sigma, 10.0)
    np.testing.assert_allclose(found.fixed_variance, 50.0)


def test_a_run_without_noise_is_taken_to_have_a_little() -> None:
    """Half a thousandth of the root mean square of the values, 50: 0.025 each."""
    found = Measurement.of(_recording(_steady(40))).image_values(steady_object=True)
    assert found.noise == pytest.approx(0.025)


def test_a_masked_frame_is_dark_in_the_total_and_left_out_of_the_light_s_change() -> None:
    values = _steady(20)
    values[4] *= 3
    valid = np.arange(20) != 4
    measured = Measurement.of(_recording(values, frame_valid=valid))
    assert measured.total[4] == 0
    assert measured.light_change() == 0
    assert len(measured) == 20


def test_a_total_of_the_position_patterns_themselves_stays_as_it_is() -> None:
    """Three-step fringes add to the light: flicker and noise cannot be told apart there."""
    values = 50 + np.random.default_rng(3).standard_normal((200, 6))
    recording = Recording(plan_of("fourier-3step", 200, 16), values, np.ones(200, np.bool_), 50e-6)
    measured = Measurement.of(recording)
    np.testing.assert_array_equal(measured.steady_total, measured.total)
    np.testing.assert_allclose(measured.total, values.sum(axis=1) / 3)


@pytest.mark.parametrize(("frames", "smoothed"), [(7, False), (8, True)])
def test_fewer_than_eight_frames_are_too_few_to_smooth_the_light(frames: int, *, smoothed: bool) -> None:
    values = _steady(frames)
    values[1::2, 4:] += 1.0
    measured = Measurement.of(_recording(values))
    assert bool(np.ptp(measured.steady_total) < np.ptp(measured.total) / 2) is smoothed


def test_the_mean_light_must_stand_five_standard_errors_above_nothing() -> None:
    """Frames of 2 and 0 in turn, about a mean: 100 of them have a deviation of 1 and a standard error of 0.1."""

    def observed(mean: float) -> Measurement:
        values = np.zeros((100, 6))
        values[:, 4] = mean + np.tile([1.0, -1.0], 50)
        measured = Measurement.of(_recording(values))
        measured.observe(steady=False)
        return measured

    assert observed(0.51).total.mean() == pytest.approx(0.51)
    with pytest.raises(InputError, match=r"a mean light of 0\.49 with a standard error of 0\.1"):
        observed(0.49)


def test_no_valid_frame_says_nothing_of_an_image() -> None:
    nothing = _recording(_steady(4), frame_valid=np.zeros(4, np.bool_))
    with pytest.raises(InputError, match="no valid frame in a recording of 4"):
        Measurement.of(nothing).image_values(steady_object=True)
    with pytest.raises(InputError, match="no frame with light in a recording of 4 frames, 0 of them valid"):
        Measurement.of(nothing).observe(steady=True)


def test_the_variance_of_values_divided_by_the_lamp_is_divided_by_its_square() -> None:
    """At 1.2 times the mean light the same noise is 1 / 1.44 of the variance, at 0.8 times it is 1 / 0.64."""
    lamp = np.linspace(1.2, 0.8, 200)
    found = Measurement.of(_recording(_steady(200) * lamp[:, None])).image_values(steady_object=True)
    np.testing.assert_allclose(found.fixed_variance[0] / found.fixed_variance[-1], 0.64 / 1.44, rtol=0.02)
