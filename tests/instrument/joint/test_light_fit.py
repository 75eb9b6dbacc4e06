"""Leak, edge loss and offsets put into values by hand, and found in what a true image leaves of them."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from instrument.joint.light_fit import LightFit, fit_light
from instrument.joint.prediction import Predictor
from instrument.measurement import LightModel, Measurement, Parameter
from instrument.numerics import smooth
from instrument.plan import Plan
from instrument.reconstruction import Problem
from instrument.recording import Recording
from instrument.schemes import scheme_of
from instrument.tracking import as_trajectory
from protocols import Bytes, Floats, Singles
from tests.support.objects import letter
from tests.support.simulation import shifted, simulate

SIZE, FRAMES, SUPERPIXEL = 64, 400, 4
LEAK, EDGE_LOSS = 0.03, 0.02
OFFSET = np.array([0.003, -0.002, 0.001, 0.0025])


def _path(time_s: Floats) -> Floats:
    angle = 2 * np.pi * time_s / (FRAMES * 300e-6)
    way: Floats = np.stack([21 + 17 * np.cos(angle), 20 + 17 * np.sin(angle)], axis=1)
    return way


@dataclass(frozen=True, eq=False)
class _Run:
    """An ideal run, and its true image."""

    problem: Problem
    image: Singles
    predictor: Predictor


@pytest.fixture(scope="module")
def run() -> _Run:
    recording = simulate(
        Plan(frames=FRAMES, image_size=SIZE, superpixel=SUPERPIXEL), letter(SIZE, "letter-B", 24), _path
    )
    assert recording.truth is not None
    measurement = Measurement.of(recording)
    motion = as_trajectory(recording.truth.displacement_px, FRAMES, measurement.frame_time_s)
    problem = Problem.of(measurement, measurement.image_values(steady_object=True), motion, region="inside")
    area = problem.region
    part = recording.truth.image[area.top : area.top + area.height, area.left : area.left + area.width]
    return _Run(problem, part.astype(np.float32), Predictor.of(problem))


def _lost(patterns: Bytes, image: Floats, place_px: Floats) -> Floats:
    """``(frames, 4)``: light of an object at its places, times the sides of lit samples that border dark ones, in pixels."""
    around = np.pad(patterns.astype(np.float64), ((0, 0), (1, 1), (1, 1)))
    lit = around[:, 1:-1, 1:-1]
    dark = 4 - around[:, :-2, 1:-1] - around[:, 2:, 1:-1] - around[:, 1:-1, :-2] - around[:, 1:-1, 2:]
    scale = patterns.shape[-1] // SIZE
    sides = (lit * dark * scale).reshape(-1, SIZE, scale, SIZE, scale).mean(axis=(2, 4))
    return np.array(
        [
            [float((shifted(image, x, y) * sides[k]).sum()) for k, (x, y) in enumerate(places)]
            for places in place_px.tolist()
        ]
    )


def _bent(run: _Run, leak: float = LEAK, edge_loss: float = EDGE_LOSS, offset: Floats = OFFSET) -> Problem:
    """The same run on a bench that is not ideal: what the true image predicts, with all of it added by hand.

    Patterns of c_i and c_j changes lose 2 (c_i + c_j) / 64 of the light for a loss of 1 a side, half of it each of a pair.
    """
    problem, values = run.problem, run.problem.values
    ideal = run.predictor.predict(problem, run.image, None)
    side = edge_loss / SUPERPIXEL
    whole = np.zeros((SIZE, SIZE))
    area = problem.region
    whole[area.top : area.top + area.height, area.left : area.left + area.width] = run.image
    lost = _lost(scheme_of(Plan(frames=FRAMES, image_size=SIZE)).fixed_patterns, whole, problem.places.fixed)
    of_pair = ideal.total * 2 * values.pairs.sum(axis=1) / SIZE
    played = np.column_stack(
        [
            ideal.values - side * lost,
            (ideal.total + ideal.difference - side * of_pair) / 2,
            (ideal.total - ideal.difference - side * of_pair) / 2,
        ]
    )
    before = np.concatenate([played.ravel()[:1], played.ravel()[:-1]]).reshape(played.shape)
    arrived = (1 - leak) * played + leak * before
    bent = replace(
        values,
        positive=arrived[:, 4],
        negative=arrived[:, 5],
        fixed=arrived[:, :4] + ideal.total[:, None] * offset,
    )
    return replace(problem, values=bent)


def _fit(run: _Run, problem: Problem, light: LightModel | None = None) -> LightFit:
    prediction = run.predictor.predict(problem, run.image, None)
    return fit_light(problem, prediction, light or LightModel(), SUPERPIXEL)


def test_all_of_it_is_found_together(run: _Run) -> None:
    """In one step, but for products of leak and loss: a loss of 0.02 loses c = 0.03 of itself, and some to the next pattern."""
    found = _fit(run, _bent(run))
    assert (found.light.leak.source, found.light.edge_loss.source) == ("fitted", "fitted")
    assert found.light.leak.value == pytest.approx(LEAK, rel=0.02)
    assert found.light.edge_loss.value == pytest.approx(EDGE_LOSS, rel=0.06)
    np.testing.assert_allclose(found.offset, OFFSET, atol=2e-4)
    assert found.light.leak.sigma is not None
    assert 0 < found.light.leak.sigma < 0.001
    sigma = np.sqrt(np.diagonal(found.offset_covariance))
    assert ((sigma > 0) & (sigma < 0.001)).all()
    np.testing.assert_allclose(found.offset_covariance, found.offset_covariance.T)


@pytest.mark.parametrize(("leak", "edge_loss"), [(LEAK, 0.0), (0.0, EDGE_LOSS)])
def test_one_alone_is_found_to_a_hundredth_and_not_mistaken_for_the_other(
    run: _Run, leak: float, edge_loss: float
) -> None:
    found = _fit(run, _bent(run, leak, edge_loss, np.zeros(4))).light
    assert found.leak.value == pytest.approx(leak, rel=0.01)
    assert found.edge_loss.value == pytest.approx(edge_loss, rel=0.01)
    assert (found.leak.source == "fitted", found.edge_loss.source == "fitted") == (leak > 0, edge_loss > 0)


def test_after_a_few_steps_it_is_exact(run: _Run) -> None:
    """Each time with the values corrected by what was found, and patterns as they then act."""
    bent = _bent(run)
    values = np.column_stack([bent.values.fixed, bent.values.positive, bent.values.negative])
    values -= run.predictor.predict(run.problem, run.image, None).total[:, None] * np.append(OFFSET, [0.0, 0.0])
    values[0, 0] *= 1 - LEAK  # dark before the first pattern
    plan = Plan(frames=FRAMES, image_size=SIZE, superpixel=SUPERPIXEL)
    recording = Recording(plan, values, np.ones(FRAMES, np.bool_), 50e-6)
    measurement = replace(Measurement.of(recording), variance=np.full(values.shape, 0.01))
    problem = replace(run.problem, steady=False).remeasured(measurement)
    light = LightModel()
    for _ in range(4):
        prediction = run.predictor.of_field(problem).predict(problem, run.image, None)
        light = fit_light(problem, prediction, light, SUPERPIXEL).light
        measurement = measurement.lit_by(light)
        problem = problem.remeasured(measurement)
    assert light.leak.value == pytest.approx(LEAK, rel=0.01)
    assert light.edge_loss.value == pytest.approx(EDGE_LOSS, rel=0.01)


def test_an_ideal_run_has_nothing_of_it(run: _Run) -> None:
    found = _fit(run, _bent(run, 0.0, 0.0, np.zeros(4)))
    for parameter in (found.light.leak, found.light.edge_loss):
        assert (parameter.value, parameter.source) == (0.0, "assumed")
        assert parameter.sigma is not None
    assert np.abs(found.offset).max() < 2e-4


@pytest.mark.parametrize("sign", [1, -1])
def test_a_negative_leak_or_loss_is_none(run: _Run, sign: int) -> None:
    found = _fit(run, _bent(run, sign * LEAK, sign * EDGE_LOSS, np.zeros(4)))
    taken = (found.light.leak.source == "fitted", found.light.edge_loss.source == "fitted")
    assert taken == ((True, True) if sign > 0 else (False, False))


def test_what_was_found_before_is_added_to(run: _Run) -> None:
    """What is left of a leak after 0.1 was taken out: c = 0.1 + 0.9 x 0.03."""
    before = LightModel(leak=Parameter(value=0.1, source="fitted"), edge_loss=Parameter(value=0.05, source="fitted"))
    found = _fit(run, _bent(run), before)
    assert found.light.leak.value == pytest.approx(0.1 + 0.9 * LEAK, rel=0.01)
    assert found.light.edge_loss.value == pytest.approx(0.05 + EDGE_LOSS, rel=0.02)


@pytest.mark.parametrize("source", ["given", "calibrated"])
def test_what_is_given_is_not_touched(run: _Run, source: str) -> None:
    given = Parameter.model_validate({"value": 0.0, "source": source})
    only_leak = _fit(run, _bent(run, LEAK, 0.0, np.zeros(4)), LightModel(edge_loss=given))
    assert only_leak.light.edge_loss == given
    assert only_leak.light.leak.value == pytest.approx(LEAK, rel=0.01)
    only_loss = _fit(run, _bent(run, 0.0, EDGE_LOSS, np.zeros(4)), LightModel(leak=given))
    assert only_loss.light.leak == given
    assert only_loss.light.edge_loss.value == pytest.approx(EDGE_LOSS, rel=0.01)


def test_values_that_say_nothing_leave_what_is_assumed(run: _Run) -> None:
    """Prediction and noise are not numbers; or the noise is 100 times the light."""
    bent = _bent(run)
    broken = run.predictor.predict(bent, run.image, None)
    nan = fit_light(bent, replace(broken, values=np.full_like(broken.values, np.nan)), LightModel(), SUPERPIXEL)
    assert nan.light == LightModel()
    values = bent.values
    dark = replace(
        bent,
        values=replace(
            values,
            difference_variance=np.full(FRAMES, 1e8),
            fixed_variance=np.full((FRAMES, 4), 1e8),
        ),
    )
    found = _fit(run, dark).light
    assert (found.leak.value, found.edge_loss.value) == (0.0, 0.0)
    assert found.leak.sigma is not None
    assert found.leak.sigma > 0.015


def test_noise_scatters_as_stated(run: _Run) -> None:
    """Noise of 1 on every value, 0.5 % of the light: twelve draws."""
    clean = _bent(run)
    deviation: list[float] = []
    for seed in range(12):
        noise = np.random.default_rng(seed).standard_normal((FRAMES, 6))
        values = clean.values
        noisy = replace(
            values,
            positive=values.positive + noise[:, 4],
            negative=values.negative + noise[:, 5],
            fixed=values.fixed + noise[:, :4],
            difference_variance=np.full(FRAMES, 2.0),
            fixed_variance=np.ones((FRAMES, 4)),
        )
        found = _fit(run, replace(clean, values=noisy)).light
        assert found.leak.sigma is not None
        assert found.edge_loss.sigma is not None
        deviation += [
            (found.leak.value - LEAK) / found.leak.sigma,
            (found.edge_loss.value - EDGE_LOSS) / found.edge_loss.sigma,
        ]
    assert np.abs(deviation).max() < 4
    assert 0.85 < np.sqrt(np.mean(np.square(deviation))) < 1.5


def test_the_predicted_total_is_that_of_the_pair_smoothed(run: _Run) -> None:
    values = run.problem.values
    pair = values.positive + values.negative
    ideal = run.predictor.predict(run.problem, run.image, None)
    np.testing.assert_allclose(ideal.total, smooth(pair, np.ones(FRAMES), orders=(1,)).values)
    np.testing.assert_allclose(ideal.values, values.fixed, atol=0.01 * float(pair.mean()))
    np.testing.assert_allclose(ideal.difference, values.difference, atol=0.03 * float(pair.mean()))
