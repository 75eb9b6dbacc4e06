"""Runs whose path and image contradict each other, and what explains it: fringes wired otherwise, frames lost as a whole."""

from dataclasses import replace

import numpy as np
import pytest

from instrument import Analysis, Plan, Recording, analyse, simulate
from instrument.measurement import Measurement, after_lost_frame, by_patterns
from protocols import Floats

PLAN = Plan(frames=600, image_size=64)


def path(time_s: Floats) -> Floats:
    return np.stack([14 * time_s / PLAN.run_time_s, 5 * time_s / PLAN.run_time_s], axis=1)


@pytest.fixture(scope="module")
def recording() -> Recording:
    """At 150 photons of an all-on pattern."""
    scene = {
        "object": "letter-B",
        "object_height_px": 18,
        "start_px": [24.4, 29.7],
        "noise": {"kind": "poisson", "peak_counts": 150.0, "seed": 5},
    }
    return simulate(PLAN, scene, path=path)


@pytest.fixture(scope="module")
def planned(recording: Recording) -> Analysis:
    return analyse(recording)


def without(recording: Recording, frame: int) -> Recording:
    """Lose a frame; the last one is there twice, so that the run is as long as planned."""
    values = np.concatenate([np.delete(recording.values, frame, axis=0), recording.values[-1:]])
    return replace(recording, values=values)


def test_nothing_is_explained_where_nothing_contradicts(planned: Analysis) -> None:
    assert planned.figures.found == ()


@pytest.mark.parametrize(
    ("order", "told"),
    [
        ([2, 3, 0, 1, 4, 5], "the fringes along x and y are exchanged"),
        pytest.param(
            [1, 0, 2, 3, 4, 5], "phases in the place of x come in the reverse order", marks=pytest.mark.thorough
        ),
        pytest.param(
            [3, 2, 0, 1, 4, 5],
            "the fringes along x and y are exchanged, and phases in the place of x come in the reverse order",
            marks=pytest.mark.thorough,
        ),
    ],
)
def test_fringes_that_are_wired_otherwise_are_named_and_taken_so(
    recording: Recording, planned: Analysis, order: list[int], told: str
) -> None:
    found = analyse(replace(recording, values=recording.values[:, order]))
    assert found.figures.found == (told,)
    assert any(told in doubt for doubt in found.figures.doubts)
    assert found.trajectory is not None
    assert planned.trajectory is not None
    np.testing.assert_allclose(found.trajectory.displacement_px, planned.trajectory.displacement_px, atol=0.1)


@pytest.mark.thorough
def test_axes_exchanged_near_the_diagonal_are_told_by_the_image_alone() -> None:
    """An aeroplane near the diagonal goes 6 px along x and 15 along y: its position values stay those of its blurred image."""
    plan = Plan(frames=1666)
    noise = {"kind": "poisson", "peak_counts": 50.0, "seed": 4}
    way_px_s = np.array([5.6, 15.1]) / plan.run_time_s
    run = simulate(
        plan,
        {"object": "plane", "start_px": [34.8, 30.5], "noise": noise},
        path=lambda time_s: np.multiply.outer(time_s, way_px_s),
    )
    found = analyse(replace(run, values=run.values[:, [2, 3, 0, 1, 4, 5]])).figures
    assert found.found == ("the fringes along x and y are exchanged",)
    assert found.displacement_mse_px2 is not None
    assert found.displacement_mse_px2 < 0.1


@pytest.mark.parametrize("lost", [pytest.param(40, marks=pytest.mark.thorough), 250])
def test_a_frame_that_was_lost_is_named_and_what_follows_moved_back(
    recording: Recording, planned: Analysis, lost: int
) -> None:
    found = analyse(without(recording, lost))
    (told,) = found.figures.found
    first, *last = (int(word) for word in told.split() if word.isdigit())
    assert told.startswith("a whole frame was lost at frame")
    assert first <= lost + 1
    assert lost - 1 <= (last or [first])[0]
    assert found.figures.psnr_db is not None
    assert planned.figures.psnr_db is not None
    assert found.figures.psnr_db > planned.figures.psnr_db - 0.5
    assert found.figures.frames_masked == (last or [first])[0] - first + 1
    assert (last or [first])[0] - first < 40


def test_values_are_moved_by_patterns(recording: Recording) -> None:
    run = Measurement.of(recording)
    late = by_patterns(run, 1)
    np.testing.assert_array_equal(late.values.ravel()[:-1], run.values.ravel()[1:])
    assert np.flatnonzero(~late.valid).tolist() == [599]
    early = by_patterns(run, -2)
    np.testing.assert_array_equal(early.values.ravel()[2:], run.values.ravel()[:-2])
    np.testing.assert_array_equal(early.variance.ravel()[2:], run.variance.ravel()[:-2])
    assert np.flatnonzero(~early.valid).tolist() == [0]


def test_frames_after_a_lost_one_are_moved_by_a_frame_and_those_in_doubt_masked(recording: Recording) -> None:
    run = Measurement.of(recording)
    moved = after_lost_frame(run, 100, 98, 103)
    np.testing.assert_array_equal(moved.values[101:], run.values[100:-1])
    np.testing.assert_array_equal(moved.variance[101:], run.variance[100:-1])
    np.testing.assert_array_equal(moved.values[:101], run.values[:101])
    assert np.flatnonzero(~moved.valid).tolist() == [98, 99, 100, 101, 102, 103]
    assert np.flatnonzero(~after_lost_frame(run, 100, 100, 99).valid).tolist() == [100]


def bars(counts: float, seed: int) -> Recording:
    """Record bars of 2 px, of whose fringes a third is left, in little light."""
    scene = {
        "object": "bars",
        "object_height_px": 2,
        "start_px": [27, 26],
        "noise": {"kind": "poisson", "peak_counts": counts, "seed": seed},
    }
    way_px = 10 / PLAN.run_time_s
    return simulate(PLAN, scene, path=lambda time_s: np.stack([way_px * time_s, way_px * time_s], axis=1))


def test_a_shift_that_the_counts_leave_open_is_found_by_path_and_image() -> None:
    run = bars(90.0, 6)
    early = replace(run, values=np.roll(run.values.ravel(), -1).reshape(run.values.shape))
    before, after = analyse(run).figures, analyse(early).figures
    assert Measurement.of(early).findings == ()
    assert after.found == ("all values come one pattern early",)
    assert before.displacement_mse_px2 is not None
    assert after.displacement_mse_px2 is not None
    assert after.displacement_mse_px2 < 2 * before.displacement_mse_px2


def test_a_contradiction_that_nothing_explains_is_told(recording: Recording) -> None:
    """The fringes along x are those of an object that goes the other way."""
    back = simulate(
        PLAN,
        {"object": "letter-B", "object_height_px": 18, "start_px": [24.4, 29.7], "noise": {"kind": "none"}},
        path=lambda time_s: path(time_s) * [-0.5, 1.0],
    )
    light: Floats = back.values * recording.values[:, 4:].sum() / back.values[:, 4:].sum()
    values = recording.values.copy()
    values[:, :2] = np.random.default_rng(2).poisson(light[:, :2])
    found = analyse(replace(recording, values=values).first(300))
    assert found.figures.found[-1] == "the position values are not those of the image's object"
    (told,) = [doubt for doubt in found.figures.doubts if doubt.startswith(found.figures.found[-1])]
    assert float(told.split("off by ")[1].split(" times")[0]) > 1.5
