"""The judging half of the streaming tracker, on paths that it must follow exactly."""

import numpy as np
import pytest

from instrument.tracking.filter_bank import FilterBank
from protocols import Floats


def test_the_first_frame_is_where_counting_begins_and_the_second_is_met() -> None:
    """Through two positions every parabola goes, so that the displacement is their difference."""
    found = FilterBank((0.0, 0.0)).push(np.array([[10.0, -2.0], [13.0, -8.0]]))
    np.testing.assert_allclose(found, [[0, 0], [3, -6]], atol=1e-9)


def accelerated(frame: Floats) -> Floats:
    """Along x with 2 px a frame and an acceleration of 0.3 px a frame squared, along y against it."""
    way = 2 * frame + 0.15 * frame**2
    return np.stack([way, -way], axis=-1)


@pytest.mark.parametrize("ahead_frames", [(0.0, 0.0), (1 / 3, -0.25)])
def test_constant_acceleration_is_followed_exactly(ahead_frames: tuple[float, float]) -> None:
    """The answer holds ``ahead_frames`` after each measurement, and frame 0 is taken as long after its own."""
    frame = np.arange(300.0)
    found = FilterBank(ahead_frames).push(accelerated(frame) + np.array([40.0, 7.0]))
    for axis, ahead in enumerate(ahead_frames):
        expected = accelerated(frame + ahead)[:, axis] - accelerated(np.array([ahead]))[0, axis]
        np.testing.assert_allclose(found[2:, axis], expected[2:], atol=1e-6)


def test_any_cut_of_the_stream_gives_the_same_to_the_bit() -> None:
    places = np.random.default_rng(4).normal(size=(200, 2)).cumsum(axis=0)
    whole = FilterBank((0.1, 0.2)).push(places)
    bank = FilterBank((0.1, 0.2))
    np.testing.assert_array_equal(np.concatenate([bank.push(part) for part in np.split(places, [1, 2, 50, 50])]), whole)


def test_axes_do_not_know_of_each_other() -> None:
    places = np.random.default_rng(5).normal(size=(200, 2))
    both = FilterBank((0.0, 0.0)).push(places)
    turned = FilterBank((0.0, 0.0)).push(np.ascontiguousarray(places[:, ::-1]))
    np.testing.assert_array_equal(both, turned[:, ::-1])


def test_noise_at_rest_is_calmed_and_a_start_is_followed() -> None:
    """White noise of 1 px at rest; its calmest member averages over some 50 frames. Then 3 px a frame, at once."""
    noise = np.random.default_rng(6).normal(size=(2000, 2))
    way = np.zeros((2000, 2))
    way[1500:] = 3.0 * np.arange(500)[:, None]
    error = FilterBank((0.0, 0.0)).push(noise + way) - way
    error -= error[1000:1500].mean(axis=0)
    assert error[1000:1500].std() < 0.4
    assert np.abs(error[1500:1520]).max() < 8.0, "twenty frames at rest would be 60 px"
    assert np.abs(error[1700:].mean()) < 0.3
