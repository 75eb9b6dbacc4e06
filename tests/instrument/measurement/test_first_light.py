"""What a run shows of its light by itself: offsets of a known background, and nothing where it says nothing."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from instrument.config import LightTable
from instrument.measurement import Measurement, Parameter, first_light
from instrument.measurement.ripple import Ripple
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.schemes import scheme_of
from protocols import Floats
from tests.support.objects import letter
from tests.support.plans import plan_of
from tests.support.simulation import Path2D, simulate

SIZE, FRAMES = 64, 400
RUN_S = FRAMES * 300e-6
PLAN = Plan(frames=FRAMES, image_size=SIZE)


def _round_trip(time_s: Floats) -> Floats:
    """A circle of 18 px about (20, 20) px: more than half a period of 32 px along each axis."""
    angle = 2 * np.pi * time_s / RUN_S
    way: Floats = 20 + 18 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return way


def _down_only(time_s: Floats) -> Floats:
    way: Floats = 4 + np.outer(time_s / RUN_S, [0.0, 34.0])
    return way


def _behind() -> Floats:
    """A bar at the upper right and a weak one below: 110 px of light."""
    image = np.zeros((SIZE, SIZE))
    image[5:15, 50:60] = 1.0
    image[50:54, 30:40] = 0.25
    return image


@cache
def _recorded(path: Path2D = _round_trip, *, background: bool = True, seed: int = 0) -> Recording:
    recording = simulate(PLAN, letter(SIZE, "letter-B", 20), path)
    if background:
        recording.values[:] += simulate(PLAN, _behind(), lambda time_s: np.zeros((len(time_s), 2))).values
    noise = 0.03 * np.sqrt(SIZE * SIZE / 2) * np.random.default_rng(seed).standard_normal(recording.values.shape)
    recording.values[:] += noise
    return recording


def _expected_offsets() -> Floats:
    """Sum of B (P_k - 1/2) over the total light of object and background."""
    patterns = scheme_of(PLAN).fixed_patterns
    scale = patterns.shape[-1] // SIZE
    means = patterns.reshape(4, SIZE, scale, SIZE, scale).mean(axis=(2, 4))
    light = float(letter(SIZE, "letter-B", 20).sum()) + float(_behind().sum())
    return np.asarray(np.einsum("kyx,yx->k", means - 0.5, _behind()) / light, np.float64)


def test_offsets_are_those_of_the_background_s_light_in_the_patterns() -> None:
    deviation: list[Floats] = []
    for seed in range(4):
        found = first_light(_recorded(seed=seed)).light.offsets
        assert [offset.source for offset in found] == ["fitted"] * 4
        sigma = np.array([offset.sigma for offset in found], np.float64)
        assert ((sigma > 0) & (sigma < 0.02)).all()
        deviation.append((np.array([offset.value for offset in found]) - _expected_offsets()) / sigma)
    assert np.abs(_expected_offsets()).max() > 0.05
    assert np.abs(deviation).max() < 3


def test_the_centre_of_the_signals_is_that_of_the_offsets() -> None:
    """A signal is twice its pattern's share beyond 1/2: two patterns of phase 0 and 90 degrees, of base 1/2."""
    measured = first_light(_recorded())
    x0, x90, y0, y90 = (offset.value for offset in measured.light.offsets)
    np.testing.assert_allclose(measured.centre, [2 * x0 + 2j * x90, 2 * y0 + 2j * y90])
    assert Measurement.of(_recorded()).centre.tolist() == [0, 0]


def test_without_a_background_no_offset_counts() -> None:
    found = first_light(_recorded(background=False)).light.offsets
    assert [(offset.value, offset.source) for offset in found] == [(0.0, "assumed")] * 4
    assert all(offset.sigma is not None for offset in found)


def test_an_axis_without_motion_has_no_circle_and_no_offset() -> None:
    found = first_light(_recorded(_down_only)).light.offsets
    assert found[:2] == (Parameter(value=0.0),) * 2
    np.testing.assert_allclose([offset.value for offset in found[2:]], _expected_offsets()[2:], atol=0.03)
    assert [offset.source for offset in found[2:]] == ["fitted"] * 2


def test_a_run_of_fast_turns_is_averaged_over_fewer_frames() -> None:
    """4 turns of 400 frames, 1.1 px a frame: the mean of 25 frames lies well inside the circle of a period of 32 px."""

    def fast(time_s: Floats) -> Floats:
        return _round_trip(4 * time_s)

    found = first_light(_recorded(fast)).light.offsets
    np.testing.assert_allclose([offset.value for offset in found], _expected_offsets(), atol=0.02)


def test_an_object_at_rest_says_nothing() -> None:
    def resting(time_s: Floats) -> Floats:
        return np.full((len(time_s), 2), 9.0)

    found = first_light(_recorded(resting)).light.offsets
    assert found == (Parameter(value=0.0),) * 4


def test_what_the_bench_states_stays() -> None:
    given = replace(_recorded(), light=LightTable(leak=0.1, edge_loss=0.02))
    light = first_light(given).light
    assert light.leak == Parameter(value=0.1, source="given")
    assert light.edge_loss == Parameter(value=0.02, source="given")


def test_offsets_that_were_calibrated_stay() -> None:
    measured = Measurement.of(_recorded())
    offsets = (Parameter(value=0.01, source="calibrated"),) * 4
    found = first_light(measured.lit_by(measured.light.model_copy(update={"offsets": offsets})))
    assert found.light.offsets == offsets


def test_found_once_it_is_found() -> None:
    once = first_light(_recorded())
    assert once.light_found
    assert first_light(once) is once
    again = first_light(Measurement.of(_recorded()))
    assert again.light == once.light


def test_a_leak_is_taken_out_before_offsets_are_looked_for() -> None:
    leaky = _recorded(background=False)
    flat = leaky.values.ravel()
    mixed = 0.9 * flat + 0.1 * np.concatenate([[0.0], flat[:-1]])
    found = first_light(replace(leaky, values=mixed.reshape(leaky.values.shape)))
    assert found.light.leak.source == "fitted"
    assert found.light.leak.value == pytest.approx(0.1, abs=0.02)
    assert [offset.source for offset in found.light.offsets] == ["assumed"] * 4


def test_a_lamp_that_ripples_is_found_and_taken_out() -> None:
    recording = _recorded(background=False)
    ripple = Ripple(frequency_hz=100, amplitude=0.2, phase_rad=1.0)
    rippling = replace(recording, values=recording.values * (1 + ripple.at(recording.pattern_time_s)))
    measured = first_light(rippling)
    (found,) = measured.light.ripples
    assert found.frequency_hz == pytest.approx(100, abs=0.3)
    assert found.amplitude == pytest.approx(0.2, abs=0.01)
    assert found.lamp_share == pytest.approx(1.0, abs=0.1)
    seen = ripple.at(measured.pattern_time_s[:, 4:].mean(axis=1))
    left = float((measured.total / measured.total.mean() - 1) @ seen) / float(seen @ seen)
    assert abs(left) < 0.03
    assert first_light(recording).light.ripples == ()


def test_schemes_without_circles_have_no_offsets() -> None:
    """A centroid has no period; Hadamard patterns alone see no position; seven frames are too few."""
    for plan in (
        plan_of("moment-hadamard", 100, SIZE),
        plan_of("hadamard", 100, SIZE),
        Plan(frames=7, image_size=SIZE),
    ):
        recording = simulate(plan, letter(SIZE, "letter-B", 20), _down_only)
        assert first_light(recording).light.offsets == ()
