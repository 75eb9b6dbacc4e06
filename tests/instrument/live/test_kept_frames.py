"""What the live image keeps of a run: the newest frame of each pattern, and where the object was during its two pictures."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument.live.kept_frames import KeptFrames
from instrument.plan import Plan
from instrument.schemes import FourierHadamardSettings
from protocols import Floats

CYCLE = 64
"""Patterns of an image of 8 x 8 pixels."""

PLAN = Plan(frames=200, image_size=8, scheme=FourierHadamardSettings(fourier_cycles=1))
AFTER_MIDDLE = np.array([1 / 4, 5 / 12])
"""Of six patterns the fifth, H+, is halfway through at 4.5 / 6 of its frame, and H- at 5.5 / 6."""


def _numbered(frames: int) -> Floats:
    """Give values that tell of which frame they are."""
    return np.arange(frames)[:, None] + np.arange(6) / 10


def _kept(path_px: Floats, room: int = 20) -> KeptFrames:
    kept = KeptFrames(PLAN, room)
    kept.add(_numbered(len(path_px)), path_px)
    return kept


def test_of_each_pattern_the_newest_frame_stays_and_the_oldest_comes_first() -> None:
    """150 frames are two cycles of 64 and 22 frames: of the first ten patterns those of frames 128 to 137."""
    kept = _kept(np.zeros((150, 2)), room=30)
    newest = [*range(128, 150), *range(64 + 22, 64 + 30)]
    assert kept.frame.tolist() == newest
    assert (kept.seen, len(kept)) == (150, 30)
    assert kept.oldest_first().tolist() == [*range(22, 30), *range(22)]
    np.testing.assert_array_equal(kept.values, _numbered(150)[newest])


def test_before_the_first_cycle_is_over_only_what_came_is_given() -> None:
    kept = _kept(np.zeros((7, 2)))
    assert kept.oldest_first().tolist() == list(range(7))
    assert kept.frame.tolist() == [*range(7), *[-1] * 13]


@pytest.mark.parametrize("where", ["values", "path"])
def test_a_frame_that_is_not_whole_leaves_the_one_before_it(where: str) -> None:
    """Frame 64 + 3 would renew frame 3."""
    values, path = _numbered(70), np.zeros((70, 2))
    (values if where == "values" else path)[67, 1] = np.nan
    kept = KeptFrames(PLAN, 20)
    kept.add(values, path)
    assert kept.frame[:7].tolist() == [64, 65, 66, 3, 68, 69, 6]
    assert kept.seen == 70


def test_at_constant_velocity_both_pictures_are_where_the_object_was() -> None:
    """From the third frame on; before, no two steps agree on a velocity, and it is taken as 0."""
    velocity = np.array([3.0, -2.0])
    kept = _kept(np.arange(10.0)[:, None] * velocity)
    for place_px, after in zip((kept.positive_px, kept.negative_px), AFTER_MIDDLE, strict=True):
        np.testing.assert_allclose(place_px[2:10], (np.arange(2.0, 10)[:, None] + after) * velocity)
        np.testing.assert_array_equal(place_px[:2], [[0, 0], velocity])


@settings(deadline=None)
@given(before=st.integers(-9, 9), after=st.integers(-9, 9))
def test_the_velocity_is_the_smaller_of_two_steps_and_0_where_they_disagree(before: int, after: int) -> None:
    """The second axis goes the other way with the steps exchanged."""
    path = np.array([[0, 0], [before, -after], [before + after, -after - before]], np.float64)
    velocity = float(np.sign(before)) * min(abs(before), abs(after)) if before * after > 0 else 0.0
    found = _kept(path)
    np.testing.assert_allclose(found.positive_px[2], path[2] + AFTER_MIDDLE[0] * velocity * np.array([1, -1]))
    np.testing.assert_allclose(found.negative_px[2], path[2] + AFTER_MIDDLE[1] * velocity * np.array([1, -1]))


@settings(max_examples=50, deadline=None)
@given(
    cuts=st.lists(st.integers(1, 149), max_size=6, unique=True),
    lost=st.sets(st.integers(0, 149), max_size=15),
    seed=st.integers(0, 2**32 - 1),
)
def test_how_the_stream_is_cut_makes_no_difference_to_the_bit(cuts: list[int], lost: set[int], seed: int) -> None:
    values, path = _numbered(150), np.random.default_rng(seed).normal(size=(150, 2)).cumsum(axis=0)
    values[list(lost), 0] = np.nan
    whole, parts = KeptFrames(PLAN, 25), KeptFrames(PLAN, 25)
    whole.add(values, path)
    for first, end in itertools.pairwise([0, *sorted(cuts), 150]):
        parts.add(values[first:end], path[first:end])
    for one, other in (
        (whole.frame, parts.frame),
        (whole.values, parts.values),
        (whole.positive_px, parts.positive_px),
        (whole.negative_px, parts.negative_px),
        (whole.oldest_first(), parts.oldest_first()),
    ):
        np.testing.assert_array_equal(one, other)


def test_a_run_shorter_than_all_patterns_has_no_cycle() -> None:
    """50 frames of 64 patterns: what comes after the plan's last frame shows its first pattern again."""
    kept = KeptFrames(PLAN.model_copy(update={"frames": 50}), 20)
    kept.add(_numbered(53), np.zeros((53, 2)))
    assert kept.frame[:4].tolist() == [50, 51, 52, 3]


def test_its_memory_is_that_of_its_room() -> None:
    """A pattern takes 2 + 1 whole numbers, 6 values and 2 places of 2, of 8 bytes each."""
    assert KeptFrames(PLAN, 20).nbytes == 20 * 8 * (2 + 1 + 6 + 4) == _kept(np.zeros((150, 2))).nbytes
