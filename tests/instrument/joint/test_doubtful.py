"""What makes a path uncertain beside the noise: its size by hand."""

from dataclasses import replace

import numpy as np
import pytest

from instrument.joint.doubtful import of_offsets, of_uneven_light, spread_px2
from instrument.joint.evidence import AxisView, Evidence, View
from instrument.tracking import Trajectory
from protocols import Floats

FRAMES = 101


def _path(displacement_px: Floats) -> Trajectory:
    sigma_px = np.full((FRAMES, 2), 0.3)
    valid = np.ones(FRAMES, np.bool_)
    return Trajectory(displacement_px, sigma_px, 3e-4, "joint", valid)


def _along(px: float) -> Floats:
    return np.outer(np.linspace(0, 1, FRAMES), [0.6 * px, 0.8 * px])


def test_an_offset_moves_the_place_by_its_value_over_the_slope_as_far_as_position_patterns_tell() -> None:
    """Along x: slope 2 beside Hadamard slopes of 1, so that 4 of 5 is theirs; the derivative by the offset goes from 0 to 50."""
    frame = np.arange(FRAMES)
    by_offset = np.zeros((FRAMES, 4))
    by_offset[:, 0] = np.linspace(0.0, 50.0, FRAMES)
    x = AxisView(View(np.zeros(FRAMES), np.tile([2.0, 0.0], (FRAMES, 1))), by_offset, None)
    y = AxisView(View(np.zeros(FRAMES), np.tile([0.0, 2.0], (FRAMES, 1))), np.zeros((FRAMES, 4)), None)
    evidence = Evidence(x, y, View(np.zeros(FRAMES), np.ones((FRAMES, 2))), misfit=1.0)
    found = of_offsets(evidence, np.diag([0.01**2, 1.0, 1.0, 1.0]), frame, _path(_along(10.0)))
    np.testing.assert_allclose(np.sqrt(found[:, 0]), 0.8 * by_offset[:, 0] * 0.01 / 2)
    assert not found[:, 1].any()
    assert not of_offsets(evidence, np.zeros((2, 2)), frame, _path(_along(10.0))).any()


def _gaussian(sigma_x: float, sigma_y: float) -> Floats:
    y, x = np.mgrid[:64, :64]
    return np.asarray(np.exp(-((x - 30) ** 2) / (2 * sigma_x**2) - (y - 33) ** 2 / (2 * sigma_y**2)), np.float64)


def test_light_of_a_field_that_bends_makes_the_place_doubtful_by_gradient_times_spread() -> None:
    """Light 100 + s^2 / 100 over s = 0 .. 50 px: a gradient of s / 50 over the mean of 108.4, from 0 on."""
    place_px = np.linspace(0, 50, FRAMES)
    light = 100 + place_px**2 / 100
    found = of_uneven_light(light, _path(_along(50.0)), _gaussian(3.0, 5.0).astype(np.float32), 1)
    gradient = place_px / 50 / light.mean()
    np.testing.assert_allclose(np.sqrt(found[2:-2]), gradient[2:-2, None] * [9.0, 25.0], rtol=0.03, atol=0.002)


def test_what_is_doubtful_counts_from_the_frame_that_the_path_counts_from() -> None:
    """The light of before, and frame 50 half way: the gradient there is 25 / 50 over the mean."""
    place_px = np.linspace(0, 50, FRAMES)
    light = 100 + place_px**2 / 100
    path = replace(_path(_along(50.0)), reference_frame=50)
    found = of_uneven_light(light, path, _gaussian(3.0, 5.0).astype(np.float32), 1)
    assert found[50].tolist() == [0, 0]
    np.testing.assert_allclose(np.sqrt(found[[2, -3]]), 24 / 50 / light.mean() * np.array([[9, 25]] * 2), rtol=0.05)


@pytest.mark.parametrize("grid", [1, 2])
def test_the_spread_is_in_px_of_the_patterns(grid: int) -> None:
    image = _gaussian(3.0, 5.0).astype(np.float32)
    np.testing.assert_allclose(spread_px2(image, grid), np.array([9.0, 25.0]) / grid**2, rtol=1e-3)


def test_a_lamp_that_drifts_evenly_an_object_at_rest_and_noise_make_nothing_doubtful() -> None:
    image, even = _gaussian(3.0, 5.0).astype(np.float32), np.linspace(100.0, 10.0, FRAMES)
    noisy = 100 + 3 * np.random.default_rng(1).standard_normal(FRAMES)
    bent = 100 + np.linspace(0, 5, FRAMES) ** 2
    assert of_uneven_light(even, _path(_along(50.0)), image, 1).max() < 1e-9
    assert not of_uneven_light(noisy, _path(_along(50.0)), image, 1).any()
    assert not of_uneven_light(bent, _path(_along(3.0)), image, 1).any()
    assert not of_uneven_light(np.full(FRAMES, np.nan), _path(_along(50.0)), image, 1).any()
