"""The step of angle and magnification: polynomials of time, fitted to residuals by hand-made slopes."""

import numpy as np
import pytest

from instrument.joint.evidence import AxisView, Evidence, View
from instrument.joint.shape_step import reshaped, shape_fit
from instrument.tracking import Trajectory
from protocols import Floats

FRAMES = 300
TIME = np.linspace(-1.0, 1.0, FRAMES)


def _slopes() -> Floats:
    """Derivatives by x, y, angle and magnification that go with nothing: 200 to each radian, 1,000 to each e-fold."""
    return np.random.default_rng(0).standard_normal((FRAMES, 4)) * [30.0, 30.0, 200.0, 1000.0]


def _noise() -> Floats:
    return np.random.default_rng(1).standard_normal(FRAMES)


def test_lines_of_angle_and_magnification_are_found() -> None:
    """0.02 rad and -0.003 either side of the middle, beside a constant of each and a path that is off by 0.1 px and more."""
    slope = _slopes()
    shape = np.stack([0.1 + 0.1 * TIME, -0.2 + 0 * TIME, 0.05 + 0.02 * TIME, 0.01 - 0.003 * TIME], axis=1)
    fit = shape_fit(np.vecdot(slope, shape), slope, np.arange(FRAMES), FRAMES)
    np.testing.assert_allclose(fit.line, [0.02, -0.003], atol=1e-9)
    np.testing.assert_allclose(fit.change, np.stack([0.02 * TIME, -0.003 * TIME], axis=1), atol=1e-9)
    assert fit.scatter < 1e-12


def test_the_uncertainty_is_that_of_a_weighted_line() -> None:
    """The variance of a slope is 1 / sum (derivative time)^2, and the change since frame 0 has four times that at the end."""
    slope = _slopes()
    fit = shape_fit(_noise(), slope, np.arange(FRAMES), FRAMES)
    for k in range(2):
        expected = 1 / float(np.sum((slope[:, 2 + k] * TIME) ** 2))
        assert fit.covariance[k, k] == pytest.approx(expected, rel=0.1)
        assert fit.variance[-1, k] == pytest.approx(4 * expected * max(1.0, fit.scatter), rel=0.1)
        assert fit.variance[0, k] == 0
    assert fit.significance < 9
    assert fit.scatter == pytest.approx(1.0, abs=0.2)


def test_significance_is_chi_square_over_the_scatter() -> None:
    """Residuals three times as large are three times the noise: no more significant."""
    slope, turn = _slopes(), 0.02 * TIME
    residual = slope[:, 2] * turn + _noise()
    once, thrice = (shape_fit(times * residual, slope, np.arange(FRAMES), FRAMES) for times in (1, 3))
    expected = 0.02**2 * float(np.sum((slope[:, 2] * TIME) ** 2))
    assert once.significance == pytest.approx(expected, rel=0.2)
    assert thrice.scatter == pytest.approx(9 * once.scatter)
    assert thrice.significance == pytest.approx(once.significance * max(1.0, once.scatter) / once.scatter)


def test_a_bend_is_taken_where_the_values_ask_for_it() -> None:
    slope = _slopes()
    straight, bent = (
        shape_fit(slope[:, 2] * turn + _noise(), slope, np.arange(FRAMES), FRAMES)
        for turn in (0.02 * TIME, 0.02 * TIME + 0.02 * (1.5 * TIME**2 - 0.5))
    )
    assert np.ptp(np.diff(straight.change[:, 0])) < 1e-9
    np.testing.assert_allclose(bent.change[:, 0], 0.02 * TIME + 0.02 * (1.5 * TIME**2 - 0.5), atol=0.003)


def test_a_step_adds_to_the_shape_so_far_and_is_taken_off_the_residuals() -> None:
    """From 1 degree and 2 % on: the shape stays 0 degrees and 1 at frame 0."""
    slope, frame = _slopes(), np.arange(FRAMES)
    change = np.stack([0.02 * TIME, -0.003 * TIME], axis=1)
    hadamard = View(np.vecdot(slope[:, 2:], change) + _noise(), slope)
    nothing = AxisView(View(np.zeros(FRAMES), np.zeros((FRAMES, 2))), np.zeros((FRAMES, 4)), None)
    part = (TIME + 1) / 2
    last = Trajectory(
        np.zeros((FRAMES, 2)),
        np.zeros((FRAMES, 2)),
        3e-4,
        "joint",
        np.ones(FRAMES, np.bool_),
        angle_deg=part,
        magnification=1 + 0.02 * part,
        pivot_px=np.zeros(2),
    )
    step = reshaped(Evidence(nothing, nothing, hadamard, misfit=1.0), frame, last)
    found = step.trajectory
    assert found.angle_deg is not None
    assert found.angle_sigma_deg is not None
    assert found.magnification is not None
    assert found.magnification_sigma is not None
    assert (found.angle_deg[0], found.magnification[0]) == (0, 1)
    assert abs(found.angle_deg[-1] - 1 - np.rad2deg(0.04)) < 3 * found.angle_sigma_deg[-1] < 1.5
    assert abs(np.log(found.magnification[-1] / 1.02) + 0.006) < 3 * found.magnification_sigma[-1] < 0.003
    assert float(np.mean(step.evidence.hadamard.residual**2)) < float(np.mean(hadamard.residual**2)) - 3
    assert step.over_sigma > 5
    assert step.evidence.x is nothing
