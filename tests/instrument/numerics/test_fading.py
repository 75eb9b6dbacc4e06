"""Parabolas through the past, against weighted least squares with all data at hand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument.numerics.fading import add, age, solve
from protocols import Floats

KEPT, STEP = 0.93, 0.07


def _faded(data: Floats, kept: float = KEPT, step: float = STEP) -> tuple[Floats, float]:
    powers, moments, curve = np.zeros(5), np.zeros((2, 3)), np.zeros((2, 3))
    for datum in data:
        age(powers, moments, kept, step)
        add(powers, moments, 0.0, datum)
    return curve, solve(powers, moments, len(data), step, curve)


@pytest.mark.parametrize("memory_frames", [1.5, 4.0, 14.0, 50.0])
@pytest.mark.parametrize("newest_frame", [0, 1, 2, 3, 10, 400, 4000])
def test_a_fading_parabola_is_that_of_weighted_least_squares(newest_frame: int, memory_frames: float) -> None:
    """From the first frame on, at the tracker's memories; in frames 0 and 1 it is lstsq's answer of least norm."""
    kept, step = 1 - 1 / memory_frames, 1 / memory_frames
    data = np.random.default_rng(newest_frame).normal(size=(newest_frame + 1, 2)) * 30
    age_frames = np.arange(newest_frame, -1, -1.0)
    root = np.sqrt(kept**age_frames)
    base = root[:, None] * np.vander(age_frames, 3, increasing=True)

    curve, share = _faded(data, kept, step)

    expected = np.linalg.lstsq(base, root[:, None] * data)[0].T
    np.testing.assert_allclose(curve * step ** np.arange(3), expected, rtol=1e-9, atol=1e-9)
    assert share == pytest.approx(np.linalg.pinv(base.T @ base)[0, 0], rel=1e-9)


def test_a_plain_parabola_counts_time_from_the_first_datum() -> None:
    data = np.random.default_rng(0).normal(size=(20, 1))
    powers, moments, curve = np.zeros(5), np.zeros((1, 3)), np.zeros((1, 3))
    for k, datum in enumerate(data):
        add(powers, moments, k / 20, datum)
    solve(powers, moments, 20, 1 / 20, curve)

    np.testing.assert_allclose(curve[0], np.polynomial.polynomial.polyfit(np.arange(20) / 20, data[:, 0], 2), rtol=1e-9)


def test_one_datum_is_its_own_parabola_and_two_share_their_difference() -> None:
    """Newest 5, older 2, a step before: b u + c u^2 = -3 at one step, half by each."""
    one, own = _faded(np.array([[4.0, -1.0]]))
    two, share = _faded(np.array([[2.0, 0.0], [5.0, 0.0]]))

    assert one.tolist() == [[4, 0, 0], [-1, 0, 0]]
    assert own == 1
    assert two[0] == pytest.approx([5, -1.5 / STEP, -1.5 / STEP**2])
    assert two[1].tolist() == [0, 0, 0]
    assert share == pytest.approx(1)


@settings(deadline=None)
@given(
    times=st.lists(st.integers(-4, 4), min_size=1, max_size=6),
    step=st.integers(-3, 3),
    kept=st.sampled_from([1.0, 0.5, 0.25]),
)
def test_to_age_data_is_to_have_taken_them_later_with_less_weight(times: list[int], step: int, kept: float) -> None:
    """In whole numbers and halves, which are exact: sums of kept (u + step)^k, and those times the datum."""
    data = np.array([[2.0 * t + 1, 3.0 - t * t] for t in times])
    powers, moments = np.zeros(5), np.zeros((2, 3))
    for time, datum in zip(times, data, strict=True):
        add(powers, moments, float(time), datum)
    age(powers, moments, kept, float(step))

    later = (np.array(times, np.float64) + step)[:, None] ** np.arange(5)
    np.testing.assert_array_equal(powers, kept * later.sum(axis=0))
    np.testing.assert_array_equal(moments, kept * data.T @ later[:, :3])
