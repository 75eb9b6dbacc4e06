"""A trajectory between its frames."""

import numpy as np
import pytest

from instrument.tracking import Trajectory
from protocols import Floats


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
