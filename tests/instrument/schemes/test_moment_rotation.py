"""What the six patterns for objects that turn are, and what their values mean."""

import numpy as np
import pytest

from instrument import simulate
from instrument.patterns import ramp, saddle
from instrument.recording import Recording
from instrument.schemes import position_of, scheme_of
from instrument.tracking import track
from protocols import Floats
from tests.support.plans import plan_of


def bar(size: int, angle_deg: float, *, length: float, width: float, x: float, y: float) -> Floats:
    """A bar with soft edges about (x, y), turned from x to y."""
    rows, columns = np.mgrid[:size, :size]
    cos, sin = np.cos(np.deg2rad(angle_deg)), np.sin(np.deg2rad(angle_deg))
    along, across = (columns - x) * cos + (rows - y) * sin, (rows - y) * cos - (columns - x) * sin
    image: Floats = np.exp(-((along / length) ** 2) - (across / width) ** 2)
    return image


def grey_values(image: Floats) -> Floats:
    """Values of a frame whose patterns are grey; all light in H+."""
    size = len(image)
    patterns = [ramp(size, "x"), ramp(size, "y"), saddle(size, "squares"), saddle(size, "product")]
    return np.array([[*(float((image * pattern).sum()) for pattern in patterns), float(image.sum()), 0.0]])


def test_saddles_by_hand() -> None:
    """M = 4: u and v are -1.5, -0.5, 0.5, 1.5; P = 1/2 + (u^2 - v^2) / 8, and 1/2 + u v / 8."""
    assert saddle(4, "squares")[0].tolist() == [0.5, 0.25, 0.25, 0.5]
    assert saddle(4, "squares")[1].tolist() == [0.75, 0.5, 0.5, 0.75]
    assert saddle(4, "product")[0].tolist() == [0.78125, 0.59375, 0.40625, 0.21875]


@pytest.mark.parametrize("angle_deg", [0, 20, 45, 80, -30])
def test_the_angle_of_a_bar_is_that_of_its_central_moments(angle_deg: float) -> None:
    """A Gaussian of widths a and b has mu20 - mu02 = (a^2 - b^2)/2 cos 2 angle and 2 mu11 = (a^2 - b^2)/2 sin 2 angle."""
    scheme = scheme_of(plan_of("moment-rotation", frames=1, image_size=64))
    reading = position_of(scheme)
    assert reading.turn is not None
    values = grey_values(bar(64, angle_deg, length=8, width=3, x=30, y=33))
    total = values @ scheme.light_weights
    centroid_px = reading.signal(values, total).real

    real, imaginary = reading.turn.elongation_px2(values[:, reading.turn.columns] / total, centroid_px, centroid_px)

    np.testing.assert_allclose(centroid_px, [[30, 33]], atol=1e-3)
    np.testing.assert_allclose(real, 27.5 * np.cos(np.deg2rad(2 * angle_deg)), atol=0.02)
    np.testing.assert_allclose(imaginary, 27.5 * np.sin(np.deg2rad(2 * angle_deg)), atol=0.02)


def test_the_variance_of_both_parts_by_hand() -> None:
    """M = 64: a share's standard deviation times 2048 for mu20 - mu02, and times 4096 for 2 mu11."""
    turn = position_of(scheme_of(plan_of("moment-rotation", frames=1, image_size=64))).turn
    assert turn is not None
    np.testing.assert_allclose(turn.part_variance_px4(np.array([[1e-6, 1e-6]])), [[4.194304, 16.777216]])
    np.testing.assert_allclose(turn.after_middle_frames, [-1 / 12, 1 / 12])


def test_each_column_says_what_it_is_and_a_run_is_that_of_moment_hadamard_with_two_patterns_more() -> None:
    scheme = scheme_of(plan_of("moment-rotation", frames=5, image_size=32))
    sequence = scheme.sequence()

    assert [(c.role, c.axis) for c in scheme.columns] == [
        *(("moment", axis) for axis in ("x", "y", None, None)),
        *[("hadamard", None)] * 2,
    ]
    assert scheme.light_weights.tolist() == [0, 0, 0, 0, 1, 1]
    assert len(sequence.planes) == 4 + 2 * 5 + (0 if (sequence.planes == 0).all(axis=(1, 2)).any() else 1)
    assert not sequence.sample_plane(int(sequence.play_order[-1])).any()


def turning(turn_deg: float, *, sigma: float = 0.0, frames: int = 400) -> Recording:
    plan = plan_of("moment-rotation", frames=frames, image_size=64, superpixel=2, upsampling=2)
    noise = {"kind": "pixel", "sigma": sigma, "seed": 1} if sigma else {"kind": "none"}

    def path(time_s: Floats) -> Floats:
        return np.outer(time_s / plan.run_time_s, [9.0, 5.0])

    image = bar(64, 10, length=12, width=5, x=28.0, y=28.0)
    image = np.where(image > 0.05, image, 0.0)
    return simulate(plan, {"noise": noise, "object_turn_deg": turn_deg}, image=image, path=path)


@pytest.mark.parametrize("turn_deg", [-90.0, 250.0])
def test_moments_alone_follow_a_turn_over_more_than_half_a_turn(turn_deg: float) -> None:
    """Without noise, what is left is dithering: some degrees at the worst place."""
    found = track(turning(turn_deg, frames=150))

    assert found.angle_deg is not None
    assert found.angle_sigma_deg is not None
    truth_deg = turn_deg * np.arange(150) / 150
    assert np.abs(found.angle_deg - truth_deg).max() < 8
    assert found.angle_deg[0] == 0
    assert found.angle_sigma_deg[0] == 0
    assert np.isfinite(found.angle_sigma_deg).all()


def test_other_schemes_see_no_angle() -> None:
    plan = plan_of("moment-hadamard", frames=20, image_size=64)
    recording = simulate(plan, image=bar(64, 10, length=12, width=5, x=28, y=28), path=lambda t: np.zeros((len(t), 2)))
    assert track(recording).angle_deg is None
