"""Values that images predict: against the run they were made by, and their slopes against small motions."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from instrument.joint.prediction import Prediction, Predictor
from instrument.measurement import Measurement
from instrument.patterns import hadamard_signs
from instrument.reconstruction import Problem
from instrument.reconstruction.problem import Places
from instrument.schemes import scheme_of
from instrument.tracking import as_trajectory
from protocols import Floats, Singles
from tests.support.objects import letter
from tests.support.plans import plan_of
from tests.support.simulation import simulate

SIZE, FRAMES = 64, 200
LIGHT = float(letter(SIZE, "letter-B", 24).sum())


def _path(time_s: Floats) -> Floats:
    """From (4, 6) px, at 400 px/s and 300 px/s."""
    way: Floats = np.array([4.0, 6.0]) + np.outer(time_s, [400.0, 300.0])
    return way


@dataclass(frozen=True, eq=False)
class _Run:
    problem: Problem
    image: Singles

    def predict(self, image: Singles | None = None, still: Singles | None = None) -> Prediction:
        """What an image predicts; None for the true one."""
        return Predictor.of(self.problem).predict(self.problem, self.image if image is None else image, still)


def _run(scheme: str, peak_counts: float | None = None) -> _Run:
    plan = plan_of(scheme, FRAMES, SIZE)
    recording = simulate(plan, letter(SIZE, "letter-B", 24), _path, peak_counts=peak_counts)
    assert recording.truth is not None
    measurement = Measurement.of(recording)
    motion = as_trajectory(recording.truth.displacement_px, FRAMES, measurement.frame_time_s)
    problem = Problem.of(measurement, measurement.image_values(steady_object=True), motion, region="inside")
    area = problem.region
    part = recording.truth.image[area.top : area.top + area.height, area.left : area.left + area.width]
    return _Run(problem, part.astype(np.float32))


@pytest.fixture(scope="module")
def fourier() -> _Run:
    return _run("fourier-hadamard")


@pytest.fixture(scope="module")
def moment() -> _Run:
    return _run("moment-hadamard")


def test_the_true_image_predicts_what_was_measured(fourier: _Run, moment: _Run) -> None:
    """But for the first and last half frame, whose displacement is taken to go on as before."""
    for run in (fourier, moment):
        found, values = run.predict(), run.problem.values
        np.testing.assert_allclose(found.total, LIGHT, rtol=1e-3)
        np.testing.assert_allclose(found.values, values.fixed, atol=0.005 * LIGHT)
        np.testing.assert_allclose(found.difference, values.difference, atol=0.02 * LIGHT)


def test_light_that_an_image_lacks_is_half_seen_by_fourier_patterns(fourier: _Run) -> None:
    """Half of the image: half of its values, and a quarter of the total light more."""
    whole, half = fourier.predict(), fourier.predict(np.asarray(fourier.image / 2, np.float32))
    np.testing.assert_allclose(half.values, whole.values / 2 + LIGHT / 4, rtol=1e-3)
    np.testing.assert_allclose(half.slopes, whole.slopes / 2, atol=1e-3)
    np.testing.assert_allclose(half.bordering, whole.bordering / 2, rtol=1e-4)
    np.testing.assert_allclose(half.difference, whole.difference / 2, rtol=1e-4)


def test_light_that_an_image_lacks_lies_where_the_image_does_for_centroids(moment: _Run) -> None:
    """Half of the image or four times as much: the same values and slopes."""
    whole = moment.predict()
    for factor in (0.5, 4):
        other = moment.predict(np.asarray(factor * moment.image, np.float32))
        np.testing.assert_allclose(other.values, whole.values, rtol=1e-4)
        np.testing.assert_allclose(other.slopes, whole.slopes, atol=1e-3)
    np.testing.assert_allclose(whole.slopes.mean(axis=0), LIGHT / SIZE * np.eye(2), atol=0.15 * LIGHT / SIZE)


@pytest.mark.parametrize("axis", [0, 1])
def test_slopes_are_the_changes_with_a_small_motion(fourier: _Run, axis: int) -> None:
    """Between whole pixels all values are bilinear: of 0.002 px both sides lie in one pixel, but for few frames."""
    step = np.zeros(2)
    step[axis] = 0.002
    places = fourier.problem.places

    def moved(sign: int) -> Prediction:
        by = sign * step
        there = Places(places.positive + by, places.negative + by, places.fixed + by)
        return _Run(replace(fourier.problem, places=there), fourier.image).predict()

    before, at, after = moved(-1), fourier.predict(), moved(1)
    of_values = (after.values - before.values) / 0.004 - at.slopes[:, :, axis]
    of_difference = (after.difference - before.difference) / 0.004 - at.difference_slopes[:, axis]
    assert np.median(np.abs(of_values)) < 0.02
    assert np.percentile(np.abs(of_values), 95) < 0.05
    assert np.percentile(np.abs(of_difference), 95) < 0.3
    assert np.abs(at.slopes[:, 2 * axis : 2 * axis + 2, axis]).max() > 10


def test_what_stands_still_adds_its_own_values_and_takes_its_light_from_what_is_lacking(fourier: _Run) -> None:
    """A square of 5 x 6 px of 0.5: 15 of the light. Its values are sums over it, and 7.5 less is spread over the field."""
    still = np.zeros((SIZE, SIZE), np.float32)
    still[10:15, 40:46] = 0.5
    alone, both = fourier.predict(), fourier.predict(still=still)
    patterns = scheme_of(plan_of("fourier-hadamard", FRAMES, SIZE)).fixed_patterns
    scale = patterns.shape[-1] // SIZE
    means = patterns.reshape(4, SIZE, scale, SIZE, scale).mean(axis=(2, 4))
    own = np.einsum("kyx,yx->k", means, still)
    np.testing.assert_allclose(both.values - alone.values, np.tile(own - 7.5, (FRAMES, 1)), atol=1e-3)
    signs = hadamard_signs(SIZE, fourier.problem.values.pairs).astype(np.float64)
    np.testing.assert_allclose(both.difference - alone.difference, np.einsum("ryx,yx->r", signs, still), atol=1e-3)
    np.testing.assert_allclose(both.slopes, alone.slopes)


def test_few_photons_have_the_variance_of_what_is_expected_and_not_of_what_came() -> None:
    """Poisson: the variance is the mean. Weighting by the counts themselves would favour low ones."""
    run = _run("fourier-hadamard", peak_counts=200.0)
    found = run.predict(np.asarray(200 / LIGHT * run.image, np.float32))
    counts = run.problem.values.fixed
    assert np.corrcoef(found.variance.ravel(), found.values.ravel())[0, 1] > 0.999
    assert found.variance.mean() == pytest.approx(float(counts.mean()), rel=0.1)
    assert found.variance.max() / found.variance.min() == pytest.approx(
        found.values.max() / found.values.min(), rel=0.3
    )
