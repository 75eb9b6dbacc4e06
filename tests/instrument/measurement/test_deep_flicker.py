"""A lamp that goes nearly dark: its noise is weighed, and estimated, as dark as it was."""

import numpy as np
import pytest

from instrument.measurement import LightModel, Measurement, Ripple, noise_variance
from instrument.measurement.ripple import lamp_factor
from instrument.plan import Plan
from instrument.recording import Recording
from protocols import Floats

LINE = Ripple(frequency_hz=100.0, amplitude=0.6, phase_rad=0.0)
HALF_AMBIENT = Ripple(frequency_hz=100.0, amplitude=0.6, phase_rad=0.0, lamp_share=0.5)


def measured(values: Floats, *, photon_counts: bool = False) -> Measurement:
    plan, valid = Plan(frames=len(values), image_size=16), np.ones(len(values), np.bool_)
    return Measurement.of(Recording(plan, values, valid, 50e-6, photon_counts=photon_counts))


def test_a_lamp_by_hand() -> None:
    """1.6 at its phase, 1 a quarter of a period later, 0.4 at the half; half of it with a lamp's share of a half."""
    time_s = np.array([0.0, 2.5e-3, 5e-3])
    np.testing.assert_allclose(lamp_factor(time_s, (LINE,)), [1.6, 1.0, 0.4])
    np.testing.assert_allclose(lamp_factor(time_s, (HALF_AMBIENT,)), [1.3, 1.0, 0.7])
    np.testing.assert_allclose(lamp_factor(time_s, (LINE, LINE)), [2.56, 1.0, 0.16])
    assert lamp_factor(time_s, (LINE.model_copy(update={"amplitude": 1.0}),))[2] == 0.01


def test_noise_of_values_that_were_divided_by_a_dark_lamp_is_as_much_larger() -> None:
    found = measured(np.full((40, 6), 100.0), photon_counts=True)
    lit = found.lit_by(LightModel(ripples=(LINE,)))
    lamp = 1 + LINE.at(found.pattern_time_s)
    np.testing.assert_allclose(lit.variance, found.variance / lamp**2)
    np.testing.assert_allclose(lit.lit_by(LightModel()).variance, found.variance)


def test_noise_is_told_from_flicker_by_the_brightness_that_it_was_divided_by() -> None:
    """Noise of 3 a value, divided by brightnesses of 1 and 0.25 in turn: 9 to 1 per cent of 4,000 frames' scatter."""
    noise = 3 * np.random.default_rng(3).standard_normal((4000, 2))
    brightness = np.tile([1.0, 0.25], 2000)
    valid, both = np.ones(4000, np.bool_), np.array([1.0, 1.0])
    found = noise_variance(100 + noise / brightness[:, None], both, valid, brightness)
    assert found == pytest.approx(9.0, rel=0.1)
    assert noise_variance(100 + noise, both, valid, np.ones(4000)) == noise_variance(100 + noise, both, valid)


def test_noise_that_is_estimated_from_few_frames_has_students_interval() -> None:
    """Eight frames are as good as 2 degrees of freedom: 4.303 where 1.960 stands for a noise that is known."""
    values = 100 + np.random.default_rng(1).standard_normal((8, 6))
    assert measured(values).student_ratio == pytest.approx(4.303 / 1.960, rel=1e-3)
    assert measured(values.round(), photon_counts=True).student_ratio == 1.0
