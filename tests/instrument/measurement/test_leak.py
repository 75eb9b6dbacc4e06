"""Light of the picture before: mixed in by hand, and taken out again."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.measurement import Measurement
from instrument.measurement.leak import difference_variance_ratio, leak_seen, leak_variance_ratio, without_leak
from instrument.plan import Plan
from instrument.schemes import scheme_of
from instrument.session import simulate
from protocols import Floats
from tests.support.objects import letter
from tests.support.plans import plan_of
from tests.support.simulation import simulate as simulate_by_hand


def _with_leak(light: Floats, leak: float) -> Floats:
    """(1 - c) v_k + c v_(k-1), in the dark before the first pattern."""
    flat = light.ravel()
    before = np.concatenate([[0.0], flat[:-1]])
    return np.asarray((1 - leak) * flat + leak * before, np.float64).reshape(light.shape)


def _path(time_s: Floats) -> Floats:
    """The diagonal, 20 px in 0.12 s, from (8, 8) px on."""
    way: Floats = 8 + np.outer(time_s / 0.12, [20.0, 20.0])
    return way


@given(seed=st.integers(0, 2**32 - 1), leak=st.floats(0, 0.4), frames=st.integers(1, 20), patterns=st.integers(2, 7))
def test_what_a_leak_mixes_is_taken_apart_exactly(seed: int, leak: float, frames: int, patterns: int) -> None:
    light = np.random.default_rng(seed).uniform(0, 100, (frames, patterns))
    np.testing.assert_allclose(without_leak(_with_leak(light, leak), leak), light, atol=1e-9)


def test_two_patterns_by_hand() -> None:
    """C = 1/4: 8 in the dark gives 6; 4 after 8 gives 3 + 2 = 5."""
    np.testing.assert_allclose(without_leak(np.array([[6.0, 5.0]]), 0.25), [[8.0, 4.0]])


@given(seed=st.integers(0, 2**32 - 1), leak=st.floats(0.01, 0.4), row=st.integers(1, 8), column=st.integers(0, 3))
def test_behind_a_hole_the_error_falls_by_the_leak_from_pattern_to_pattern(
    seed: int, leak: float, row: int, column: int
) -> None:
    """The hole is filled by the mean of its column: what that is wrong by comes back times -c / (1 - c), each time."""
    light = np.random.default_rng(seed).uniform(0, 100, (10, 4))
    arrived = _with_leak(light, leak)
    hole = arrived.copy()
    hole[row, column] = np.nan
    wrong = (np.nanmean(hole[:, column]) - arrived[row, column]) / (1 - leak)

    found = without_leak(hole, leak)

    assert np.argwhere(np.isnan(found)).tolist() == [[row, column]]
    first = row * 4 + column
    error = (found - light).ravel()
    np.testing.assert_allclose(error[:first], 0, atol=1e-9)
    steps = np.arange(1, light.size - first)
    np.testing.assert_allclose(error[first + 1 :], wrong * (-leak / (1 - leak)) ** steps, atol=1e-9)


def test_without_a_leak_nothing_is_touched() -> None:
    arrived = np.array([[1.0, np.nan]])
    assert without_leak(arrived, 0.0) is arrived


@pytest.mark.parametrize("leak", [0.0, 0.04, 0.125, 0.3])
def test_the_variances_are_those_of_noise_that_went_through(leak: float) -> None:
    """White noise: the variance of a value, and that of the difference of two that follow each other."""
    noise = np.random.default_rng(1).standard_normal((200_000, 2))
    left = without_leak(noise, leak)
    assert left.var() == pytest.approx(leak_variance_ratio(leak), rel=0.01)
    of_independent = 2 * leak_variance_ratio(leak)
    assert (left[:, 0] - left[:, 1]).var() == pytest.approx(difference_variance_ratio(leak) * of_independent, rel=0.012)


def test_variances_by_hand() -> None:
    """C = 1/4: a value has 2 times its variance. Successive values correlate by -1/3: a difference has 4/3 of two alone."""
    assert leak_variance_ratio(0.25) == pytest.approx(2.0)
    assert difference_variance_ratio(0.25) == pytest.approx(4 / 3)


@pytest.mark.parametrize(("transition_s", "leak"), [(0.0, 0.0), (4e-6, 0.04), (12.5e-6, 0.125)])
def test_a_run_shows_its_own_leak(transition_s: float, leak: float) -> None:
    """Mirrors that cross over evenly in t keep half of t of the picture before: of 50 us, 4 us make 0.04."""
    plan = Plan(frames=400, image_size=64)
    scene = {"mirror_transition_s": transition_s, "noise": {"kind": "pixel", "sigma": 0.05, "seed": 3}}
    measured = Measurement.of(simulate(plan, scene, image=letter(64, "letter-B", 24), path=_path))
    found = leak_seen(measured.arrived, measured.variance, measured.valid, measured.scheme)
    if leak == 0:
        assert found is None
        return
    assert found is not None
    assert found.source == "fitted"
    assert found.sigma is not None
    assert 0 < found.sigma < 0.01
    assert abs(found.value - leak) < 3 * found.sigma


def test_a_slope_that_is_steep_by_chance_is_no_leak() -> None:
    """25 photons a value, of which the Hadamard pattern changes 2: a slope is 0 +- 0.3, and one of 0.6 would be c = 0.27."""
    scheme = scheme_of(Plan(frames=600, image_size=64))
    found: list[float] = []
    for seed in range(100):
        rng = np.random.default_rng([5, seed])
        light, change = np.full((600, 6), 25.0), 2.0 * rng.standard_normal(600)
        light[:, 4] += change
        light[:, 5] -= change
        seen = leak_seen(rng.poisson(light).astype(np.float64), light, np.ones(600, np.bool_), scheme)
        found += [] if seen is None else [seen.value]
    assert found == []


def test_without_noise_an_object_at_rest_shows_none() -> None:
    """The first value of its frames is always the same: slope and uncertainty are both 0."""
    scheme = scheme_of(Plan(frames=100, image_size=64))
    light = np.full((100, 6), 25.0)
    light[:, 5] += 5 * np.random.default_rng(1).standard_normal(100)
    assert leak_seen(light, np.zeros((100, 6)), np.ones(100, np.bool_), scheme) is None


def _leaky(seed: int, leak: float, frames: int = 400, sigma: float = 0.05) -> Measurement:
    recording = simulate_by_hand(Plan(frames=frames, image_size=64), letter(64, "letter-B", 24), _path, seed=seed)
    lit = np.sqrt(64 * 64 / 2)
    noise = sigma * lit * np.random.default_rng(seed).standard_normal(recording.values.shape)
    recording.values[:] = _with_leak(recording.values, leak) + noise
    return Measurement.of(recording)


@pytest.mark.parametrize("leak", [0.08, 0.25])
def test_over_many_runs_the_stated_sigma_is_the_scatter_and_there_is_no_bias(leak: float) -> None:
    deviation: list[float] = []
    for seed in range(20):
        run = _leaky(seed, leak)
        found = leak_seen(run.arrived, np.full_like(run.variance, 0.05**2 * 64 * 64 / 2), run.valid, run.scheme)
        assert found is not None
        assert found.sigma is not None
        deviation.append((found.value - leak) / found.sigma)
    assert abs(np.mean(deviation)) < 0.7
    assert 0.65 < np.std(deviation) < 1.45


def test_where_there_is_none_none_is_seen() -> None:
    runs = (_leaky(seed, 0.0, sigma=0.2) for seed in range(20))
    assert [leak_seen(run.arrived, run.variance, run.valid, run.scheme) for run in runs] == [None] * 20


def test_frames_that_were_not_measured_do_not_count() -> None:
    run = _leaky(0, 0.1)
    valid = run.valid & (np.arange(400) % 13 != 5)
    spoilt = np.where(valid[:, None], run.arrived, 1e6)
    found = leak_seen(spoilt, run.variance, valid, run.scheme)
    assert found is not None
    assert found.sigma is not None
    assert abs(found.value - 0.1) < 3 * found.sigma


@pytest.mark.parametrize(("frames", "seen"), [(63, False), (80, True)])
def test_fewer_than_64_frames_say_nothing(frames: int, *, seen: bool) -> None:
    run = _leaky(1, 0.2, frames, sigma=0.001)
    assert (leak_seen(run.arrived, run.variance, run.valid, run.scheme) is not None) is seen


def test_more_than_a_leak_can_be_is_none() -> None:
    """Half of the picture before, and more: the order of the patterns is another one."""
    run = _leaky(1, 0.45, sigma=0.001)
    assert leak_seen(run.arrived, run.variance, run.valid, run.scheme) is None


@pytest.mark.parametrize("scheme", ["fourier-3step", "hadamard"])
def test_a_scheme_without_a_fixed_pattern_after_a_changing_one_shows_none(scheme: str) -> None:
    recording = simulate_by_hand(plan_of(scheme, 200, 64), letter(64, "letter-B", 24), _path)
    recording.values[:] = _with_leak(recording.values, 0.1)
    run = Measurement.of(recording)
    assert leak_seen(run.arrived, run.variance, run.valid, run.scheme) is None
