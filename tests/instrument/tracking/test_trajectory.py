"""A trajectory between its frames."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument.tracking import PathCovariance, Trajectory
from instrument.tracking.trajectory import as_trajectory
from protocols import Floats, InputError


def _trajectory(displacement_px: Floats) -> Trajectory:
    frames = len(displacement_px)
    return Trajectory(displacement_px, np.zeros((frames, 2)), 3e-4, "smooth", np.ones(frames, np.bool_))


def test_as_an_array_it_is_the_displacement() -> None:
    displacement = np.array([[0.0, 0.0], [1.0, 2.0]])
    trajectory = _trajectory(displacement)

    np.testing.assert_array_equal(np.asarray(trajectory), displacement)
    assert np.asarray(trajectory, dtype=np.float32).dtype == np.float32
    assert len(trajectory) == 2


def test_constant_velocity_holds_between_and_beyond_the_middles_of_frames() -> None:
    """Frame middles are at 0.15 ms, 0.45 ms, ...; H+ of frame 0 is shown at 4.5 pictures of 50 us, H- at 5.5."""
    trajectory = _trajectory(np.outer(np.arange(4.0), [1.0, -2.0]))

    found = trajectory.at(np.array([[0.0, 225e-6], [275e-6, 1.2e-3]]))

    assert found.shape == (2, 2, 2)
    np.testing.assert_allclose(found[..., 0], [[-0.5, 0.25], [0.125 / 0.3, 3.5]])
    np.testing.assert_allclose(found[..., 1], -2 * found[..., 0])


def test_a_circle_of_40_turns_at_3_px_a_frame_is_met_within_a_thousandth_of_its_radius() -> None:
    """41.65 frames a turn; a straight line between middles would miss by 0.003 radii."""
    step = 2 * np.pi / 41.65
    frame = np.arange(100.0)
    trajectory = _trajectory(np.stack([np.cos(step * frame), np.sin(step * frame)], axis=1))
    between = np.arange(5.0, 90.0, 0.1)

    found = trajectory.at((between + 0.5) * 3e-4)

    assert np.abs(found - np.stack([np.cos(step * between), np.sin(step * between)], axis=1)).max() < 1e-3


@pytest.mark.parametrize("frames", [1, 2])
def test_one_or_two_frames_are_enough(frames: int) -> None:
    found = _trajectory(np.outer(np.arange(frames), [1.0, 2.0])).at(np.array([0.0, 150e-6]))

    np.testing.assert_allclose(found[1], [0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(found[0], [-0.5, -1.0] if frames == 2 else [0.0, 0.0], atol=1e-12)


@settings(deadline=None)
@given(
    start=st.tuples(st.integers(-9, 9), st.integers(-9, 9)),
    speed=st.tuples(st.integers(-9, 9), st.integers(-9, 9)),
    force=st.tuples(st.integers(-3, 3), st.integers(-3, 3)),
)
def test_constant_acceleration_is_met_between_and_prolonged_by_the_outermost_steps(
    start: tuple[int, int], speed: tuple[int, int], force: tuple[int, int]
) -> None:
    """Central differences of a parabola are its slope, so that the cubic is the parabola; at the ends the step is the slope."""
    a, b, c = (np.array(part, np.float64) for part in (start, speed, force))

    def way(frame: Floats) -> Floats:
        return a + b * frame[:, None] + c * frame[:, None] ** 2

    frames = way(np.arange(8.0))
    trajectory = _trajectory(frames)
    between = np.array([1.0, 1.25, 3.5, 5.75, 6.0])

    np.testing.assert_allclose(trajectory.at((between + 0.5) * 3e-4), way(between), atol=1e-9)
    found = trajectory.at(np.array([-1.5, 9.5]) * 3e-4)
    np.testing.assert_allclose(found, [frames[0] - 2 * (b + c), frames[7] + 2 * (b + 13 * c)], atol=1e-9)


def test_a_single_time_gives_a_single_place_and_middles_are_half_a_frame_late() -> None:
    trajectory = _trajectory(np.array([[0.0, 0.0], [2.0, -4.0], [3.0, 0.0]]))
    np.testing.assert_allclose(trajectory.time_s, [1.5e-4, 4.5e-4, 7.5e-4])
    assert trajectory.at(np.array(4.5e-4)).tolist() == pytest.approx([2.0, -4.0])
    np.testing.assert_allclose(trajectory.at(trajectory.time_s), trajectory.displacement_px, atol=1e-12)


def test_no_motion_and_given_places_are_trajectories_by_their_name() -> None:
    rest = as_trajectory(None, 3, 2e-4)
    given_px = as_trajectory(np.array([[0, 0], [1, 2]]), 2, 2e-4)
    assert (rest.method, given_px.method) == ("at rest", "given")
    assert rest.displacement_px.tolist() == rest.sigma_px.tolist() == [[0, 0]] * 3
    assert given_px.displacement_px.tolist() == [[0, 0], [1, 2]]
    assert (given_px.valid.tolist(), given_px.frame_time_s) == ([True, True], 2e-4)
    assert as_trajectory(given_px, 2, 9.0) is given_px


@pytest.mark.parametrize(
    ("places", "seen"),
    [
        (np.zeros((3, 2)), r"shape \(3, 2\), 0 not finite"),
        (np.zeros((2, 3)), r"shape \(2, 3\), 0 not finite"),
        (np.array([[0.0, np.nan], [np.inf, 1.0]]), r"shape \(2, 2\), 2 not finite"),
    ],
)
def test_places_that_are_not_one_for_each_frame_are_refused(places: Floats, seen: str) -> None:
    with pytest.raises(InputError, match=seen):
        as_trajectory(places, 2, 2e-4)
    with pytest.raises(InputError, match=seen):
        as_trajectory(_trajectory(places), 2, 2e-4)


def test_beyond_the_frames_in_which_it_was_seen_nothing_is_known() -> None:
    """Seen in frames 2 to 6 of 10, its covariance known in frames 4, 6 and 9."""
    path = replace(_trajectory(np.outer(np.arange(10.0), [1.0, -2.0])), sigma_px=np.full((10, 2), 0.5))
    path = replace(path, covariance=PathCovariance(np.array([4, 6, 9]), np.tile(np.eye(3), (2, 1, 1))))
    assert path.last_known == 9
    seen = np.zeros(10, np.bool_)
    seen[2:7] = True
    found = replace(path, reference_frame=2).known_where(seen)
    assert np.isfinite(found.sigma_px[:, 0]).tolist() == seen.tolist()
    assert found.last_known == 6
    assert "to x +6.00, y -12.00 px" in repr(found)
    assert "known to 0.500 px" in repr(found)
    assert found.covariance is not None
    assert found.covariance.frame.tolist() == [4, 6]
    assert found.covariance.covariance_px2.shape == (2, 2, 2)
    assert np.isfinite(path.known_where(seen).sigma_px[:, 0]).tolist() == [True] * 7 + [False] * 3  # against frame 0


def test_seen_before_its_covariance_is_known_a_path_has_none() -> None:
    path = replace(_trajectory(np.zeros((10, 2))), covariance=PathCovariance(np.array([4, 9]), np.zeros((2, 2, 2))))
    assert path.known_where(np.arange(10) < 4).covariance is None
    assert replace(path, sigma_px=np.full((10, 2), np.inf)).last_known == 9
