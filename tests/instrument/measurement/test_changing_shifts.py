"""Shifts that change at known places, where they are likeliest to, and which of a few places costs least."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from instrument.measurement import Change, Slips, cheapest_place, in_step_again
from instrument.measurement.slip_evidence import SlipEvidence
from instrument.measurement.slips import slips_of
from instrument.measurement.suspects import suspects
from protocols import Floats

FRAMES = 30
PLANNED = np.arange(6.0 * FRAMES)
"""A value that names its pattern."""


def as_they_came(shift: int, place: int) -> Floats:
    """Values, each named by its pattern, that come late by ``shift`` from a place on."""
    came = PLANNED.copy()
    came[place:] = np.arange(place, len(came)) - shift
    return came.reshape(FRAMES, 6)


@given(
    shift=st.sampled_from([-6, -3, -2, -1, 1, 2, 3, 6]),
    place=st.integers(40, 130),
    early=st.integers(0, 8),
    late=st.integers(0, 8),
)
@example(shift=6, place=42, early=1, late=0)  # six values too many, between two frames or one value before
def test_values_that_are_sure_are_those_of_their_patterns_wherever_in_the_range_the_change_was(
    shift: int, place: int, early: int, late: int
) -> None:
    told = Change(place, place - early, place + late, shift)
    slips = Slips.changing((FRAMES, 6), 0, [told])
    assert slips.shift[0] == 0
    assert slips.shift[-1] == shift
    for there in range(place - early, place + late + 1):
        mended = in_step_again(as_they_came(shift, there), slips)
        known = np.isfinite(mended).all(axis=1)
        np.testing.assert_array_equal(mended[known], PLANNED.reshape(FRAMES, 6)[known])
        # As many frames are lost as the range reaches into, and those at a place that has no value before or after it.
        assert np.count_nonzero(~known) <= (early + late) // 6 + 3 + abs(shift) // 6 + (shift != 0)


def test_frames_in_doubt_are_those_that_a_change_may_be_in() -> None:
    """By hand: of value 61 lost and the range 58 to 63, patterns 58 to 63 may be without their own: frames 9 and 10."""
    slips = Slips.changing((FRAMES, 6), 0, [Change(61, 58, 63, -1)])
    assert np.flatnonzero(~slips.sure).tolist() == [9, 10]
    assert [(part.first_frame, part.shift, part.first_pattern, part.within) for part in slips.segments] == [
        (0, 0, 0, None),
        (10, -1, 61, (58, 63)),
    ]
    assert slips.changes == (Change(61, 61, 61, -1),)


def test_shifts_may_change_again() -> None:
    """One pattern late from the start; in step from value 61 on, as one is lost; and early from value 120 on."""
    slips = Slips.changing((FRAMES, 6), 1, [Change(61, 61, 61, 0), Change(120, 120, 120, -1)])
    assert [(part.first_frame, part.shift, part.first_pattern) for part in slips.segments] == [
        (0, 1, 0),
        (10, 0, 60),
        (20, -1, 120),
    ]
    assert np.flatnonzero(~slips.sure).tolist() == [10, 20]
    came = np.concatenate([PLANNED[:61] - 1, PLANNED[61:120], PLANNED[121:], [0]]).reshape(FRAMES, 6)
    mended = in_step_again(came, slips)
    known = np.isfinite(mended).all(axis=1)
    np.testing.assert_array_equal(mended[known], PLANNED.reshape(FRAMES, 6)[known])
    assert np.count_nonzero(~known) <= 4


def test_the_cheapest_place_is_that_of_the_least_sum_before_and_after() -> None:
    before, after = np.array([1.0, 1, 1, 9, 9, 9]), np.array([9.0, 9, 2, 1, 1, 1])
    assert cheapest_place(before, after, 0.5) == (3, 3, 3)
    assert cheapest_place(before, after, 1.5) == (3, 2, 3)  # value 2 costs 1 more by the other side
    assert cheapest_place(after, before, 0.5)[0] in {0, 6}
    assert cheapest_place(np.zeros(4), np.ones(4), 0.5) == (4, 4, 4)
    assert cheapest_place(np.ones(4), np.zeros(4), 0.5) == (0, 0, 0)


@pytest.mark.parametrize(("lost", "shift"), [(1203, -1), (1801, -1), (1501, 1)])
def test_a_place_that_the_counts_do_not_tell_is_suspected(lost: int, shift: int) -> None:
    """Photons scatter by 5 where levels differ by 2 to 10."""
    random, frames = np.random.default_rng(4), 400
    light = np.array([23.0, 29, 25, 19, 25, 25]) + 5 * random.standard_normal((frames, 6))
    pair = 2 * random.standard_normal(frames)
    light[:, 4] += pair
    light[:, 5] -= pair
    flat = light.ravel()
    came = np.append(np.delete(flat, lost), 25) if shift < 0 else np.insert(flat, lost, 25)[:-1]
    asked = came.reshape(frames, 6), np.zeros((frames, 6), bool), np.full(6, 25.0), (4, 5)
    assert not slips_of(*asked).any
    evidence = SlipEvidence.of(*asked)
    assert evidence is not None
    found = suspects(evidence)
    assert sum(change.shift == shift and change.first <= lost <= change.last for change in found) == 1
    assert {change.shift for change in found[:6]} == {-3, -2, -1, 1, 2, 3}  # the likeliest of each shift
    assert [abs(change.shift) for change in found[12:]] == [1] * 8
    assert all(change.last - change.first <= 2 * 12 * 6 for change in found)


def test_nothing_is_suspected_of_a_pair_alone() -> None:
    """A shift by one of two patterns is half a frame."""
    light = np.random.default_rng(4).standard_normal((400, 1)) * [30, -30] + 100
    evidence = SlipEvidence.of(light, np.zeros((400, 2), bool), np.full(2, 1.0), (0, 1))
    assert evidence is not None
    assert not evidence.has_levels
    assert suspects(evidence) == ()


def test_where_no_cost_is_a_number_the_change_may_be_anywhere() -> None:
    """As of an image that a path which ran away has left without numbers."""
    assert cheapest_place(np.full(4, np.nan), np.full(4, np.nan), 10.0) == (0, 0, 4)
    assert cheapest_place(np.array([0.0, 0.0, 5.0, 5.0]), np.array([5.0, 5.0, 0.0, 0.0]), 5.0) == (2, 1, 3)
