"""Patterns of a frame brought to the moment of its total light."""

import numpy as np
import pytest

from instrument.measurement.lamp import to_one_moment

TIME_S = (np.arange(60, dtype=np.float64).reshape(10, 6) + 0.5) * 50e-6
PAIR = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 1.0])
ALL = np.ones(10, np.bool_)
INSIDE = np.s_[1:-1]


def test_light_that_rises_evenly_gives_the_exact_ratio() -> None:
    """Light 1 + t / 1 ms, known between the last two patterns of a frame, 250 us after its start."""
    moment_s = TIME_S[:, 4:].mean(axis=1)
    found = to_one_moment(1 + 1000 * moment_s, ALL, TIME_S, PAIR)
    expected = (1 + 1000 * moment_s[:, None]) / (1 + 1000 * TIME_S)
    np.testing.assert_allclose(found[INSIDE], expected[INSIDE])
    assert found[5, 0] == pytest.approx((1 + 1.75) / (1 + 1.525))


def test_before_the_first_total_and_after_the_last_one_the_light_is_taken_as_constant() -> None:
    found = to_one_moment(np.arange(1.0, 11.0), ALL, TIME_S, PAIR)
    np.testing.assert_array_equal(found[0, :4], 1.0)
    assert found[-1, 5] == 1.0


def test_weights_say_when_the_total_is_measured() -> None:
    """Three steps of weight 1/3, minus or plus: in the middle of the frame."""
    weights = np.array([1.0, 1.0, -1.0, 1.0, 1.0, 1.0]) / 3
    total = 5 + 100 * TIME_S.mean(axis=1)
    found = to_one_moment(total, ALL, TIME_S, weights)
    np.testing.assert_allclose(found[INSIDE], ((total[:, None]) / (5 + 100 * TIME_S))[INSIDE])


def test_steady_light_stays() -> None:
    np.testing.assert_array_equal(to_one_moment(np.full(10, 3.0), ALL, TIME_S, PAIR), 1.0)


def test_where_the_light_is_unknown_nothing_is_changed_and_others_are_as_if_it_were_not_there() -> None:
    moment_s = TIME_S[:, 4:].mean(axis=1)
    total = 1 + 1000 * moment_s
    valid = np.arange(10) != 4
    spoilt = np.where(np.arange(10) == 4, 99.0, total)
    spoilt[7] = 0.0
    found = to_one_moment(spoilt, valid, TIME_S, PAIR)
    assert (found[[4, 7]] == 1.0).all()
    rest = [1, 2, 3, 5, 6, 8]
    np.testing.assert_allclose(found[rest], total[rest, None] / (1 + 1000 * TIME_S[rest]))


def test_one_frame_or_no_total_at_all_says_nothing() -> None:
    rising = np.arange(1.0, 11.0)
    assert (to_one_moment(rising, np.arange(10) == 3, TIME_S, PAIR) == 1.0).all()
    assert (to_one_moment(rising, ALL, TIME_S, np.zeros(6)) == 1.0).all()
    assert (to_one_moment(-rising, ALL, TIME_S, PAIR) == 1.0).all()
    two = to_one_moment(rising, np.arange(10) < 2, TIME_S, PAIR)
    assert two[1, 0] > 1
