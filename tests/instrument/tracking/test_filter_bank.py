"""The judging half of the streaming tracker, on paths that it must follow exactly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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


def _by_least_squares(places: Floats, delay: tuple[float, float]) -> Floats:
    """Give the answers by numpy's own least squares over the whole past, frame for frame, with the constants of the module."""
    memories, start_frames = (1.5, 4.0, 14.0, 50.0), (7, 18, 62, 220)
    theta = 1 - 1 / 60
    padded = np.concatenate([np.repeat(places[:1], 3, axis=0), places])
    third = np.diff(padded, 3, axis=0)
    found = np.zeros_like(places)
    residual_sum, noise_sum, weight_sum = np.zeros((4, 2)), np.zeros(2), 0.0
    start = np.zeros((4, 2))
    for newest in range(len(places)):
        weight_sum = theta * weight_sum + 1
        noise_sum = theta * noise_sum + third[newest] ** 2 / 20
        past, ages = places[: newest + 1], np.arange(newest, -1, -1.0)
        answers, risk = np.zeros((4, 2)), np.zeros((4, 2))
        for k, memory in enumerate(memories):
            if newest < start_frames[k]:
                first = np.linalg.lstsq(np.vander(np.arange(newest + 1.0), 3, increasing=True), past)[0]
                start[k] = [np.polynomial.polynomial.polyval(delay[axis], first[:, axis]) for axis in range(2)]
            root = np.sqrt((1 - 1 / memory) ** ages)[:, None]
            base = root * np.vander(ages, 3, increasing=True)
            curve = np.linalg.lstsq(base, root * past)[0]
            leverage = float(np.linalg.pinv(base.T @ base)[0, 0])
            now = [np.polynomial.polynomial.polyval(-delay[axis], curve[:, axis]) for axis in range(2)]
            answers[k] = np.array(now) - start[k]
            residual_sum[k] = theta * residual_sum[k] + (places[newest] - curve[0]) ** 2
            risk[k] = residual_sum[k] / (noise_sum + 1e-12 * weight_sum) + 2 * leverage
        weight = np.exp(-30 * (risk - risk.min(axis=0)))
        found[newest] = (weight * answers).sum(axis=0) / weight.sum(axis=0)
    return found


@pytest.mark.parametrize("delay_frames", [(0.0, 0.0), (1 / 3, -0.25)])
def test_every_answer_is_that_of_least_squares_over_the_whole_past(delay_frames: tuple[float, float]) -> None:
    """Noise at rest, then 2 px a frame: all four memories have their say."""
    rng = np.random.default_rng(8)
    way = np.maximum(0, np.arange(260.0) - 150)[:, None] * [2.0, -1.0]
    places = way + rng.normal(size=(260, 2)) * [1.0, 0.3]
    found = FilterBank(delay_frames).push(places)
    np.testing.assert_allclose(found, _by_least_squares(places, delay_frames), atol=1e-6)


@settings(deadline=None)
@given(
    places=st.lists(st.tuples(st.integers(-90, 90), st.integers(-90, 90)), min_size=1, max_size=3),
    shift=st.integers(-1000, 1000),
)
def test_through_three_positions_goes_every_parabola_wherever_the_first_one_is(
    places: list[tuple[int, int]], shift: int
) -> None:
    places_px = np.array(places, np.float64) + shift
    found = FilterBank((0.0, 0.0)).push(places_px)
    np.testing.assert_allclose(found, places_px - places_px[0], atol=1e-5)
