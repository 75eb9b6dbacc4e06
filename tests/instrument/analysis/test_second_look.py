"""Slips that the counts of few photons do not tell, or not surely, are told by path and image."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from instrument import Plan, Recording, analyse, simulate
from instrument.analysis.find import Found
from instrument.analysis.second_look import (
    in_step_first,
    placed_again,
    slipped_unseen,
    surely_slipped,
)
from instrument.joint.expected import at_first_sight
from instrument.joint.slipped import placed
from instrument.measurement import Change, Measurement, Slips
from protocols import Floats, InputError

PLAN = Plan(frames=400, image_size=64)
PER_FRAME = 6


def path(time_s: Floats) -> Floats:
    return np.stack([14 * time_s / PLAN.run_time_s, 5 * time_s / PLAN.run_time_s], axis=1)


def recorded(counts: float) -> Recording:
    scene = {
        "object": "letter-B",
        "object_height_px": 18,
        "start_px": [24.4, 29.7],
        "noise": {"kind": "poisson", "peak_counts": counts, "seed": 6},
    }
    return simulate(PLAN, scene, path=path)


@pytest.fixture(scope="module")
def dim() -> Recording:
    """At 50 photons of an all-on pattern."""
    return recorded(50.0)


def without(recording: Recording, value: int) -> Recording:
    """Lose a value; the last one is there twice, so that the run is as long as planned."""
    values = recording.values
    short = np.append(np.delete(values.ravel(), value), values[-1, -1])
    return replace(recording, values=short.reshape(values.shape))


def screen_of(recording: Recording) -> Callable[[Slips], Measurement]:
    return lambda slips: Measurement.of(recording, slips)


def told(measurement: Measurement | None) -> list[tuple[int, int]]:
    """Shift and first pattern of each segment."""
    assert measurement is not None
    assert measurement.slips is not None
    return [(part.shift, part.first_pattern) for part in measurement.slips.segments]


def test_path_and_image_expect_the_values_of_all_frames_also_of_those_that_are_not_valid(dim: Recording) -> None:
    """What is left of them is the noise of photons, whose variance is the value: 1 in units of it."""
    masked = dim.frame_valid.copy()
    masked[180:220] = False
    measurement = Measurement.of(replace(dim, frame_valid=masked))
    explained = at_first_sight(measurement)
    expected = explained.values()
    left = (dim.values - expected) ** 2 / expected
    assert left[180:220].mean() == pytest.approx(1.0, abs=0.35)
    assert left.mean() == pytest.approx(1.0, abs=0.06)
    assert 3 < explained.path_freedom() < 30  # a line along each axis has 4 numbers


def test_the_place_of_a_lost_value_is_told_within_a_range_that_holds_it(dim: Recording) -> None:
    run = without(dim, 1001)
    screen = screen_of(run)
    raw = screen(Slips.none(PLAN.frames))
    suspect = Slips.changing((PLAN.frames, PER_FRAME), 0, [Change(1040, 960, 1080, -1)])
    best = placed(raw, suspect, at_first_sight(screen(suspect)))
    (change,) = best.slips.changes
    assert abs(change.place - 1001) <= 3
    first, last = best.slips.segments[1].within or (0, 0)
    assert first <= 1001 <= last
    assert last - first < 12
    wrong = replace(suspect.changes[0], first=960, last=1080, shift=1)
    other = Slips.changing((PLAN.frames, PER_FRAME), 0, [wrong])
    assert placed(raw, other, at_first_sight(screen(other))).cost > best.cost + 500


def test_a_slip_that_the_counts_do_not_tell_is_told_by_path_and_image(dim: Recording) -> None:
    """Asked of a run that refuses, as one does whose path leaves the field by the slip."""
    run = without(dim, 1001)
    unseen = Measurement.of(run)
    assert told(unseen) == [(0, 0)]

    def ask(measurement: Measurement) -> int:
        if len(told(measurement)) == 1:
            raise InputError(saw="this", expected="that", remedy="none")
        return 7

    found, answer = in_step_first(unseen, ask, screen_of(run))
    assert answer == 7
    (_, before), (shift, place) = told(found)
    assert (before, shift) == (0, -1)
    assert abs(place - 1001) <= 3
    kept = found.valid
    np.testing.assert_array_equal(found.arrived[kept], Measurement.of(dim).arrived[kept])
    assert np.count_nonzero(~kept) <= 5
    assert any("early by 1 pattern from pattern" in finding.text for finding in found.findings)


def test_no_slip_is_told_where_there_is_none(dim: Recording) -> None:
    measurement = Measurement.of(dim)

    def refuse(_: Measurement) -> int:
        raise InputError(saw="this", expected="that", remedy="none")

    with pytest.raises(InputError):
        in_step_first(measurement, refuse, screen_of(dim))
    assert surely_slipped(measurement, screen_of(dim)) is measurement
    assert slipped_unseen(replace(measurement, slips=None), screen_of(dim)) == (None, False)


def test_a_shift_of_which_the_counts_are_not_sure_is_made_sure(dim: Recording) -> None:
    """The counts leave 101 frames as not sure."""
    run = without(dim, 1802)
    unsure = Measurement.of(run)
    assert np.count_nonzero(~unsure.valid) > 50
    found = surely_slipped(unsure, screen_of(run))
    assert [shift for shift, _ in told(found)] == [0, -1]
    assert np.count_nonzero(~found.valid) <= 5
    np.testing.assert_array_equal(found.arrived[found.valid], Measurement.of(dim).arrived[found.valid])


def test_half_a_frame_that_is_lost_is_told_to_be_lost_and_not_gained(dim: Recording) -> None:
    """The counts take it for one gained, and leave all that follows as not sure."""
    run = dim
    for _ in range(3):
        run = without(run, 1300)
    unsure = Measurement.of(run)
    assert np.count_nonzero(~unsure.valid) > 100
    found = surely_slipped(unsure, screen_of(run))
    assert [shift for shift, _ in told(found)] == [0, -3]
    kept = found.valid[:398]
    assert np.count_nonzero(~kept) <= 8
    np.testing.assert_array_equal(found.arrived[:398][kept], Measurement.of(dim).arrived[:398][kept])


def test_what_was_found_is_kept_where_its_image_places_the_change_where_it_was(dim: Recording) -> None:
    run = without(dim, 1300)
    measurement, calls = Measurement.of(run), list[Measurement]()
    nothing = Found(measurement)

    def find(asked: Measurement) -> Found:
        calls.append(asked)
        return nothing

    assert placed_again(measurement, nothing, find, screen_of(run)) == (measurement, nothing)
    assert not calls


def test_an_analysis_places_the_change_and_is_as_good_as_without_it(dim: Recording) -> None:
    figures = analyse(without(dim, 1300)).figures
    (found,) = figures.found
    place = int(found.split("from pattern ")[1].split()[0])
    assert abs(place - 1300) <= 3
    assert figures.frames_masked <= 5
    assert figures.displacement_mse_px2 is not None
    assert figures.displacement_mse_px2 < 0.03
    assert figures.psnr_db is not None
    assert figures.psnr_db > 20.5


def test_a_change_is_looked_for_twelve_frames_to_both_sides_of_where_the_counts_saw_it(dim: Recording) -> None:
    run = without(dim, 1802)
    unsure = Measurement.of(run)
    assert unsure.slips is not None
    asked: list[Slips] = []

    def screen(slips: Slips) -> Measurement:
        asked.append(slips)
        return Measurement.of(run, slips)

    surely_slipped(unsure, screen)
    (change,) = unsure.slips.changes
    suspect = next(slips for slips in asked if slips.changes)
    doubtful = np.flatnonzero(~suspect.sure)
    assert doubtful.tolist() == list(range(change.place // PER_FRAME - 12, change.place // PER_FRAME + 13))


@pytest.mark.parametrize("not_sure", [12, 13])
def test_a_shift_is_looked_at_again_where_the_counts_leave_more_than_twelve_frames_to_one_change(
    dim: Recording, not_sure: int
) -> None:
    run = without(dim, 1001)
    first = 1001 // PER_FRAME * PER_FRAME
    told_so = Slips.changing((PLAN.frames, PER_FRAME), 0, [Change(1001, first, first + PER_FRAME * (not_sure - 1), -1)])
    measurement = Measurement.of(run, told_so)
    assert np.count_nonzero(~told_so.sure[:-1]) == not_sure
    found = surely_slipped(measurement, screen_of(run))
    assert (found is not measurement) == (not_sure > 12)
