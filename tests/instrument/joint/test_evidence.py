# pyright: reportPrivateUsage=false
"""What values say of a displacement: motion and amplitude are told apart, and slow errors make the uncertainty larger."""

from dataclasses import replace

import numpy as np
import pytest

from instrument.joint.evidence import AxisView, Evidence, View, evidence_of
from instrument.joint.path_step import path_step
from instrument.joint.prediction import Predictor
from instrument.measurement import Measurement
from instrument.numerics import smooth
from instrument.plan import Plan
from instrument.reconstruction import Problem
from instrument.tracking import Trajectory
from protocols import Floats
from tests.support.objects import blobs
from tests.support.simulation import simulate

SIZE, FRAMES = 64, 100


def _path(time_s: Floats) -> Floats:
    return np.outer(time_s / 30e-3, [6.0, -4.0])


@pytest.fixture(scope="module")
def problem() -> Problem:
    """A noise-free run with the object where it is thought to be."""
    recording = simulate(Plan(frames=FRAMES, image_size=SIZE), blobs(SIZE, 3), _path)
    assert recording.truth is not None
    measurement = Measurement.of(recording)
    still = np.ones(FRAMES, np.bool_)
    path = Trajectory(recording.truth.displacement_px, np.zeros((FRAMES, 2)), 300e-6, "given", still)
    return Problem.of(measurement, measurement.image_values(steady_object=False), path, region="field")


def _seen(problem: Problem, move_px: tuple[float, float] = (0.0, 0.0), brightness: float = 1.0) -> Evidence:
    """The evidence where the object is thought to be moved, or where its image is brighter."""
    time_s = problem.values.time_s
    start = _path(np.array([150e-6]))[0]
    places = replace(
        problem.places,
        positive=_path(time_s[:, 0]) - start + move_px,
        negative=_path(time_s[:, 1]) - start + move_px,
        fixed=_path(time_s[:, 2:].ravel()).reshape(FRAMES, -1, 2) - start + move_px,
    )
    image = blobs(SIZE, 3)
    moved = replace(problem, places=places)
    prediction = Predictor.of(moved).predict(moved, (brightness * image).astype(np.float32), None)
    return evidence_of(moved, prediction, np.zeros(4))


@pytest.mark.parametrize("axis", [0, 1])
def test_a_small_move_is_the_residual_over_the_slope_and_no_amplitude(problem: Problem, axis: int) -> None:
    """Thought to be 0.02 px farther, the object is asked back by as much.

    A pattern is linear between pixels, so that the slope is another one in the few frames that pass a pixel's border.
    """
    way = (0.02, 0.0) if axis == 0 else (0.0, 0.02)
    before, after = _seen(problem), _seen(problem, way)
    own, was = after.axes[axis], before.axes[axis]
    residual = own.position.residual - was.position.residual
    assert np.median(residual / own.position.slope[:, axis]) == pytest.approx(-0.02, rel=0.02)
    assert own.amplitude is not None
    assert was.amplitude is not None
    assert np.median(np.abs(own.amplitude - was.amplitude)) < 0.01 * np.median(np.abs(residual))


def test_a_darker_image_is_amplitude_and_hardly_motion(problem: Problem) -> None:
    before, after = _seen(problem), _seen(problem, brightness=0.98)
    for own, was in zip(after.axes, before.axes, strict=True):
        assert own.amplitude is not None
        assert was.amplitude is not None
        change = np.abs(own.amplitude - was.amplitude)
        assert change.min() > 0
        assert np.abs(own.position.residual - was.position.residual).mean() < 0.15 * change.mean()


def test_hadamard_differences_ask_back_what_the_object_was_moved(problem: Problem) -> None:
    before, after = _seen(problem).hadamard, _seen(problem, (0.02, -0.02)).hadamard
    expected = after.slope @ [-0.02, 0.02]
    clear = np.abs(expected) > np.median(np.abs(expected))
    ratio = (after.residual - before.residual)[clear] / expected[clear]
    assert np.median(ratio) == pytest.approx(1.0, rel=0.01)
    assert np.quantile(np.abs(ratio - 1), 0.9) < 0.1


ROWS = 400
"""Eight blocks of fifty frames."""

BLOCK_SIGN = np.repeat([1.0, -1.0] * 4, 50)
FLAT = Trajectory(np.zeros((ROWS, 2)), np.zeros((ROWS, 2)), 300e-6, "given", np.ones(ROWS, np.bool_))


def _variance(amplitude: Floats | None, left: float = 0.0) -> Floats:
    """Variance of the displacement, (2,) at the last frame: position slopes of 3, Hadamard slopes of 1 along both axes.

    Args:
        amplitude: of both axes.
        left: what the Hadamard differences still ask for, in turn from block to block.
    """

    def axis_view(slope: list[float]) -> AxisView:
        return AxisView(View(np.zeros(ROWS), np.tile(slope, (ROWS, 1))), np.zeros((ROWS, 4)), amplitude)

    hadamard = View(left * BLOCK_SIGN, np.ones((ROWS, 2)))
    found = Evidence(axis_view([3.0, 0.0]), axis_view([0.0, 3.0]), hadamard, misfit=1.0)
    variance: Floats = path_step(found, np.arange(ROWS), FLAT).trajectory.sigma_px[-1] ** 2
    return variance


QUICK = np.tile([1.0, -1.0], ROWS // 2)
"""An amplitude without slow errors: the mean of every block is 0."""


def test_slow_errors_of_the_amplitude_count_as_far_as_position_patterns_tell() -> None:
    """Block means of +1 and -1 have the variance 8/7, times 50 frames; of the information, 9 of 9 + 1 is theirs."""
    ratio = _variance(BLOCK_SIGN) / _variance(QUICK)
    assert ratio == pytest.approx(1 + 0.9 * (50 * 8 / 7 - 1))


def test_errors_faster_than_a_block_leave_the_uncertainty_as_it_is() -> None:
    assert _variance(0.01 * BLOCK_SIGN) == pytest.approx(_variance(QUICK))


def test_what_hadamard_values_still_ask_for_counts_as_far_as_they_tell() -> None:
    """Each block asks for 50 x 0.5 with an information of 50: a square of 12.5 where noise has 1; their share is 1 of 10.

    Beside an amplitude, the scatter of eight squares, the root of 2 / 8, is taken for chance.
    """
    ratio = _variance(BLOCK_SIGN, left=0.5) / _variance(QUICK, left=0.5)
    steps, amplitude = 0.1 * (12 - 1), 0.9 * (50 * 8 / 7 - 1)
    assert ratio == pytest.approx((1 + amplitude + steps) / (1 + steps))
    assert _variance(None, left=0.5) / _variance(QUICK, left=0.5) == pytest.approx((1 + 0.1 * (12.5 - 1)) / (1 + steps))


def test_what_asks_for_less_than_noise_would_makes_nothing_surer() -> None:
    """Steps of 0.1 have a square of 0.5 where noise has 1."""
    less = _variance(BLOCK_SIGN, left=0.1) / _variance(QUICK, left=0.1)
    assert less == pytest.approx(1 + 0.9 * (50 * 8 / 7 - 1))


def test_without_slow_errors_the_uncertainty_is_that_of_the_smoothing() -> None:
    """Of the information 10 a frame, 9 by the position and 1 by the Hadamard values."""
    smoother = smooth(np.zeros(ROWS), np.full(ROWS, 10.0), absolute_weights=True).variance_to_first[-1]
    assert _variance(QUICK) == pytest.approx(np.full(2, smoother), rel=1e-6)
