"""The tracker that runs with the run."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument.plan import Plan
from instrument.recording import Recording
from instrument.tracking import StreamingTracker, track
from protocols import Floats, InputError
from tests.support.motions import FRAMES, MOTIONS, letter_b
from tests.support.simulation import simulate

PLAN = Plan(frames=FRAMES)


@cache
def _recording(motion: str, seed: int) -> Recording:
    return simulate(PLAN, letter_b(), MOTIONS[motion], sigma=0.1, seed=seed)


def _mse(found: Floats, recording: Recording) -> float:
    assert recording.truth is not None
    return float(((found - recording.truth.displacement_px) ** 2).mean())


@pytest.mark.parametrize("motion", ["I", "II"])
def test_smooth_motion_is_met_within_the_bar(motion: str) -> None:
    found = [_mse(StreamingTracker(PLAN).push(r.values), r) for r in (_recording(motion, seed) for seed in range(5))]

    assert np.mean(found) <= 0.06


def _within(motion: str, sigmas: float) -> float:
    """Share of frames whose error is less than so many stated sigma, over three draws."""
    shares: list[float] = []
    for seed in range(3):
        recording, tracker = _recording(motion, seed), StreamingTracker(PLAN)
        assert recording.truth is not None
        error = np.abs(tracker.push(recording.values) - recording.truth.displacement_px)
        known = np.isfinite(tracker.sigma_px)
        assert known.all(axis=1).sum() == FRAMES - 11, "the first frames have no scatter yet"
        shares.append(float((error < sigmas * tracker.sigma_px)[known].mean()))
    return float(np.mean(shares))


@pytest.mark.parametrize("motion", ["I", "II", "vibration-50", "stop-and-go"])
def test_its_uncertainty_holds_while_the_run_goes_on(motion: str) -> None:
    """Of normal errors 68 % are within one sigma and 95 % within two; a motion that changes at once is caught up with later."""
    assert 0.5 < _within(motion, 1) < 0.8
    assert 0.85 < _within(motion, 2) < 0.99


@pytest.mark.parametrize("motion", ["vibration-50", "vibration-200", "circle", "random-walk", "stop-and-go"])
def test_rough_motion_is_followed_better_than_frame_by_frame(motion: str) -> None:
    live: list[float] = []
    alone: list[float] = []
    for seed in range(5):
        recording = _recording(motion, seed)
        live.append(_mse(StreamingTracker(PLAN).push(recording.values), recording))
        alone.append(_mse(track(recording, "per-frame").displacement_px, recording))

    assert np.mean(live) < np.mean(alone)


@settings(max_examples=10, deadline=None)
@given(cuts=st.lists(st.integers(0, 700), max_size=8), bad=st.sets(st.integers(0, 699), max_size=20))
def test_how_the_stream_is_cut_makes_no_difference_to_the_bit(cuts: list[int], bad: set[int]) -> None:
    values = _recording("vibration-50", 3).values[:700].copy()
    values[list(bad)] = np.nan
    whole = StreamingTracker(PLAN).push(values)
    tracker = StreamingTracker(PLAN)

    pieces = np.vstack([tracker.push(piece) for piece in np.split(values, sorted(cuts))])

    np.testing.assert_array_equal(pieces, whole)


def test_frame_at_a_time_is_the_same_to_the_bit() -> None:
    values = _recording("I", 0).values
    tracker = StreamingTracker(PLAN)

    single = np.vstack([tracker.push(values[k : k + 1]) for k in range(FRAMES)])

    np.testing.assert_array_equal(single, StreamingTracker(PLAN).push(values))


def test_a_lost_frame_repeats_the_one_before_and_lost_first_frames_are_zero() -> None:
    values = _recording("I", 0).values[:60].copy()
    values[[0, 1]] = np.nan
    values[30] = 0.0
    repeated = values[2:].copy()
    repeated[28] = repeated[27]

    found = StreamingTracker(PLAN).push(values)

    assert found[:2].tolist() == [[0.0, 0.0]] * 2
    np.testing.assert_array_equal(found[2:], StreamingTracker(PLAN).push(repeated))


def test_values_of_another_shape_and_no_memory_are_refused() -> None:
    with pytest.raises(InputError, match=r"\(3, 5\)"):
        StreamingTracker(PLAN).push(np.zeros((3, 5)))
    with pytest.raises(InputError, match=r"a memory of 0.5 frames"):
        StreamingTracker(PLAN, total_memory_frames=0.5)
    assert StreamingTracker(PLAN).push(np.zeros((0, 6))).shape == (0, 2)


def test_it_works_for_ever_in_constant_memory() -> None:
    """20 rounds of a run: what it keeps has the same size after the first and after the last, and it still tracks a circle."""
    recording = _recording("circle", 0)
    tracker = StreamingTracker(PLAN)
    sizes: list[int] = []
    found = np.zeros((0, 2))
    for _ in range(20):
        found = tracker.push(recording.values)
        sizes.append(_kept_bytes(tracker))

    assert sizes[0] == sizes[-1]
    assert _mse(found, recording) < 0.5


def _kept_bytes(thing: object) -> int:
    """Bytes of all arrays that an object holds, itself or in what it holds."""
    if isinstance(thing, np.ndarray):
        return int(thing.nbytes)
    if isinstance(thing, list):
        return sum(_kept_bytes(item) for item in thing)  # pyright: ignore[reportUnknownVariableType, reportUnknownArgumentType]
    return (
        sum(_kept_bytes(item) for item in vars(thing).values())
        if type(thing).__module__.startswith("instrument")
        else 0
    )
