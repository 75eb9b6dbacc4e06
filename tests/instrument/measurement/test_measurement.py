"""One measurement of a recording: its mask, its total light, what it says of the image."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from instrument.measurement import Measurement, noise_variance
from instrument.plan import Plan
from instrument.recording import Recording
from protocols import Floats, InputError


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
