"""Travel, speed and acceleration: of paths that are known by hand, and with the uncertainty that their covariance makes."""

from dataclasses import replace

import numpy as np
import pytest

from instrument.numerics import coverage_factor, smooth
from instrument.tracking import PathCovariance, Trajectory
from protocols import Floats, InputError
from tests.support.calibrations import displacement

FRAME_S = 0.01
FRAMES = 101
TIME_S: Floats = np.arange(FRAMES, dtype=np.float64) * FRAME_S


def path(along_px: Floats, direction: tuple[float, float] = (0.6, 0.8), sigma_px: float = 0.0) -> Trajectory:
    """A path along a direction; errors of frames are independent but for that of frame 0, which all share."""
    frame = np.arange(1, FRAMES)
    covariance = sigma_px**2 * (np.eye(FRAMES - 1) + 1)
    return Trajectory(
        displacement_px=along_px[:, None] * np.array(direction),
        sigma_px=np.full((FRAMES, 2), sigma_px * np.sqrt(2)),
        frame_time_s=FRAME_S,
        method="given",
        valid=np.ones(FRAMES, np.bool_),
        covariance=PathCovariance(frame, np.stack([covariance, covariance])),
    )


def _px(speed: float, half_acceleration: float = 0.0) -> Floats:
    """Places on a parabola."""
    return np.asarray(speed * TIME_S + half_acceleration * TIME_S**2, np.float64)


def test_a_parabola_gives_its_own_numbers() -> None:
    """30 px/s at frame 0 and 8 px/s^2: after 1 s 34 px, at 38 px/s; in the middle 34 px/s."""
    fit = path(_px(30, 4)).motion_px
    assert fit is not None
    assert fit.unit == "px"
    assert fit.travel.value == pytest.approx(34.0)
    assert fit.start_speed.value == pytest.approx(30.0)
    assert fit.speed.value == pytest.approx(34.0)
    assert fit.end_speed.value == pytest.approx(38.0)
    assert fit.acceleration.value == pytest.approx(8.0)
    assert fit.off_axis_deg is None


def test_in_mm_it_is_told_along_the_axis_and_keeps_its_sign() -> None:
    """10 px/mm along (0.6, 0.8)."""
    scale = displacement(10.0, np.degrees(np.arctan2(0.8, 0.6)))
    there = replace(path(_px(30)), scale=scale).motion_mm
    back = replace(path(_px(-30)), scale=scale).motion_mm
    assert there is not None
    assert back is not None
    assert there.unit == "mm"
    assert there.speed.value == pytest.approx(3.0)
    assert back.speed.value == pytest.approx(-3.0)
    assert there.off_axis_deg is not None
    assert there.off_axis_deg.value == pytest.approx(0.0, abs=1e-9)
    assert back.off_axis_deg is not None
    assert back.off_axis_deg.value == pytest.approx(0.0, abs=1e-9)


def test_a_motion_beside_the_axis_is_told_with_its_angle_and_side() -> None:
    """Axis along x; the object goes 10 degrees towards y (down)."""
    turned = np.radians(10)
    off = replace(path(_px(30), (np.cos(turned), np.sin(turned))), scale=displacement(10.0, 0.0)).motion_mm
    assert off is not None
    assert off.off_axis_deg is not None
    assert off.off_axis_deg.value == pytest.approx(10.0)
    assert off.speed.value == pytest.approx(3.0 * np.cos(turned))


def test_displacements_in_mm_are_along_and_across() -> None:
    """5 px/mm along y (down): x to the right is across, to the other side."""
    there = replace(path(_px(10), (0.6, 0.8), 0.1), scale=displacement(5.0, 90.0, sigma=0.05))
    np.testing.assert_allclose(there.displacement_mm[-1], [10 * 0.8 / 5, -10 * 0.6 / 5], atol=1e-12)
    # 0.1 sqrt(2) px are 0.0283 mm; the scale adds 1 % of 1.6 mm, and its angle as many radians of 1.2 mm.
    np.testing.assert_allclose(
        there.sigma_mm[-1],
        np.sqrt(np.full(2, 0.1**2 * 2 / 25) + (0.01 * np.array([1.6, 1.2])) ** 2 + (0.01 * np.array([1.2, 1.6])) ** 2),
    )


def test_a_bench_without_a_calibration_says_how_to_get_one() -> None:
    here = path(_px(10))
    assert here.motion_mm is None
    with pytest.raises(InputError, match="run kinopix calibrate displacement"):
        _ = here.displacement_mm
    with pytest.raises(InputError, match="run kinopix calibrate displacement"):
        _ = here.sigma_mm


def test_uncertainties_are_those_of_least_squares_on_the_covariance() -> None:
    """Against a thousand draws with that covariance."""
    rng = np.random.default_rng(1)
    truth = path(_px(30, 4), sigma_px=0.2)
    fit = truth.motion_px
    assert fit is not None
    drawn: list[tuple[float, float, float]] = []
    for _ in range(1000):
        noise = 0.2 * rng.standard_normal((FRAMES, 2))
        one = replace(truth, displacement_px=truth.displacement_px + noise - noise[0]).motion_px
        assert one is not None
        drawn.append((one.speed.value, one.acceleration.value, one.travel.value))
    scatter = np.std(drawn, axis=0)
    assert [fit.speed.sigma, fit.acceleration.sigma, fit.travel.sigma] == pytest.approx(scatter.tolist(), rel=0.1)
    assert fit.speed.high - fit.speed.value == pytest.approx(1.959964 * fit.speed.sigma, rel=1e-6)


def test_the_scale_s_uncertainty_is_added_and_its_freedom_widens_the_interval() -> None:
    """1 % of 3 mm/s; Student's t of 4 degrees of freedom is 2.776."""
    scale = displacement(10.0, np.degrees(np.arctan2(0.8, 0.6)), sigma=0.1).model_copy(update={"degrees_of_freedom": 4})
    fit = replace(path(_px(30)), scale=scale).motion_mm
    assert fit is not None
    assert fit.speed.sigma == pytest.approx(0.03)
    assert fit.speed.value - fit.speed.low == pytest.approx(2.776445 * 0.03, rel=1e-6)


def test_a_path_that_was_not_smoothed_tells_no_speed() -> None:
    assert replace(path(_px(1)), covariance=None).motion_px is None


def test_the_smoother_s_covariance_is_that_of_its_variances() -> None:
    """Its diagonal is what is stated for the path, and it is enlarged where that is."""
    series = np.cumsum(np.random.default_rng(3).standard_normal(200)) * 0.05 + np.linspace(0, 9, 200)
    fit = smooth(series, np.full(200, 100.0), absolute_weights=True)
    sigma_px = np.sqrt(np.stack([fit.variance_to_first, 4 * fit.variance_to_first], axis=1))
    known = PathCovariance.of((fit, fit), sigma_px)
    assert known.frame[-1] == 199
    assert known.frame[0] > 0
    for axis in range(2):
        np.testing.assert_allclose(np.diag(known.covariance_px2[axis]), sigma_px[known.frame, axis] ** 2, rtol=1e-9)
    np.testing.assert_allclose(known.covariance_px2[1], 4 * known.covariance_px2[0], rtol=1e-9)
    dense = fit.covariance_to(0, np.arange(1, 200))
    assert np.linalg.eigvalsh(dense).min() > -1e-9
    np.testing.assert_allclose(np.sqrt(np.diag(dense)), np.sqrt(fit.variance_to_first[1:]), rtol=0.05)


def test_coverage_factors_are_the_tables_own() -> None:
    assert coverage_factor(None) == pytest.approx(1.959964, abs=1e-6)
    assert coverage_factor(1) == pytest.approx(12.7062, abs=1e-4)
    assert coverage_factor(10) == pytest.approx(2.2281, abs=1e-4)
    assert coverage_factor(None, 0.6827) == pytest.approx(1.0, abs=1e-3)
