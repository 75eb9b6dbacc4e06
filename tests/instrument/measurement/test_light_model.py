"""Numbers of a bench that is not ideal, where they come from, and values corrected by them."""

from dataclasses import replace

import numpy as np
import pytest

from instrument.config import LightTable
from instrument.measurement import LightModel, Measurement, Parameter, Source, bordering_share
from instrument.measurement.ripple import Ripple
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.schemes import image_rows_of
from protocols import Floats

FRAMES, SIZE = 20, 16


def _measured(values: Floats, light: LightTable | None = None) -> Measurement:
    plan = Plan(frames=FRAMES, image_size=SIZE, superpixel=4)
    recording = Recording(plan, values, np.ones(FRAMES, np.bool_), 50e-6)
    measurement = Measurement.of(recording if light is None else replace(recording, light=light))
    return replace(measurement, variance=np.full(values.shape, 3.0))


def _arrived(seed: int = 0) -> Floats:
    return np.random.default_rng(seed).uniform(20, 80, (FRAMES, 6))


@pytest.mark.parametrize(
    ("source", "free"), [("assumed", True), ("fitted", True), ("given", False), ("calibrated", False)]
)
def test_the_run_may_say_what_nobody_said_before(source: Source, *, free: bool) -> None:
    assert Parameter(value=0.1, source=source).free is free


def test_the_default_is_an_ideal_bench() -> None:
    light = LightModel()
    assert (light.leak, light.edge_loss) == (Parameter(value=0.0), Parameter(value=0.0))
    assert (light.ripples, light.offsets) == ((), ())


def test_what_the_table_states_is_given_and_the_rest_assumed() -> None:
    light = LightModel.of(LightTable(leak=0.0))
    assert light.leak == Parameter(value=0.0, source="given")
    assert light.edge_loss == Parameter(value=0.0, source="assumed")
    assert LightModel.of(LightTable(edge_loss=0.3)).edge_loss == Parameter(value=0.3, source="given")


def test_a_measurement_takes_the_stated_leak_out() -> None:
    """Mixed by hand with c = 1/4."""
    light = _arrived()
    mixed = 0.75 * light.ravel() + 0.25 * np.concatenate([[0.0], light.ravel()[:-1]])
    measured = _measured(mixed.reshape(light.shape), LightTable(leak=0.25))
    np.testing.assert_allclose(measured.values, light)
    np.testing.assert_allclose(measured.arrived.ravel(), mixed)


def test_each_correction_starts_from_what_arrived() -> None:
    measured = _measured(_arrived())
    leaky = LightModel(leak=Parameter(value=0.2))
    twice = measured.lit_by(LightModel(leak=Parameter(value=0.1), edge_loss=Parameter(value=0.2))).lit_by(leaky)
    once = measured.lit_by(leaky)
    np.testing.assert_allclose(twice.values, once.values)
    np.testing.assert_allclose(twice.variance, once.variance)
    assert measured.lit_by(measured.light) is measured
    np.testing.assert_allclose(once.lit_by(LightModel()).values, measured.values)
    np.testing.assert_allclose(once.lit_by(LightModel()).variance, 3.0)


def test_a_leak_makes_values_and_differences_noisier_as_worked_out() -> None:
    """C = 1/4: 2 times the variance of a value, and 4/3 of that of two of them for their difference."""
    measured = _measured(_arrived()).lit_by(LightModel(leak=Parameter(value=0.25)))
    np.testing.assert_allclose(measured.variance, 6.0)
    found = measured.image_values(steady_object=False)
    np.testing.assert_allclose(found.difference_variance, 2 * 6.0 * 4 / 3)
    np.testing.assert_allclose(found.fixed_variance, 6.0)


def test_a_mirror_s_edge_loss_is_that_of_a_pixel_over_its_mirrors() -> None:
    """Of four mirrors along a side one borders the dark one: a quarter of the share. Pairs get theirs back."""
    measured = _measured(_arrived()).lit_by(LightModel(edge_loss=Parameter(value=0.2)))
    assert measured.edge_loss_a_side == pytest.approx(0.05)
    rows = image_rows_of(measured.scheme)
    pair = [rows.positive, rows.negative]
    lost = 0.05 * bordering_share(rows.pairs[:FRAMES], SIZE)
    np.testing.assert_allclose(measured.values[:, pair].sum(axis=1), measured.arrived[:, pair].sum(axis=1) / (1 - lost))


def test_a_lamp_s_ripple_divides_and_an_ambient_one_is_subtracted_with_half_the_mean_total() -> None:
    measured = _measured(np.full((FRAMES, 6), 50.0))
    lamp = Ripple(frequency_hz=100, amplitude=0.2, phase_rad=0.0)
    seen = lamp.at(measured.pattern_time_s)
    np.testing.assert_allclose(measured.lit_by(LightModel(ripples=(lamp,))).values, 50 / (1 + seen))
    ambient = lamp.model_copy(update={"lamp_share": 0.0})
    np.testing.assert_allclose(measured.lit_by(LightModel(ripples=(ambient,))).values, 50 - seen * 100 / 2)


def test_frames_without_a_value_do_not_enter_the_mean_total() -> None:
    values = np.full((FRAMES, 6), 50.0)
    values[3, 2] = np.nan
    measured = replace(_measured(values), valid=np.arange(FRAMES) != 7)
    spoilt = replace(measured, arrived=np.where(np.arange(FRAMES)[:, None] == 7, 1e6, measured.arrived))
    ambient = Ripple(frequency_hz=100, amplitude=0.2, phase_rad=0.0, lamp_share=0.0)
    found = spoilt.lit_by(LightModel(ripples=(ambient,)))
    np.testing.assert_allclose(found.values[0], 50 - ambient.at(spoilt.pattern_time_s[0]) * 50)
    assert np.argwhere(np.isnan(found.values)).tolist() == [[3, 2]]


def test_offsets_move_the_centre_of_the_signals() -> None:
    """Two patterns an axis, of response 1/2: twice the offset."""
    offsets = tuple(Parameter(value=value) for value in (0.01, 0.02, -0.03, 0.04))
    measured = _measured(_arrived()).lit_by(LightModel(offsets=offsets))
    np.testing.assert_allclose(measured.centre, [0.02 + 0.04j, -0.06 + 0.08j])
    np.testing.assert_allclose(
        measured.observe(steady=False).signal + measured.centre,
        _measured(_arrived()).observe(steady=False).signal,
        atol=1e-12,
    )
