"""How sure a position is: by hand, from the variance of the values and the amplitude of the signal."""

from dataclasses import replace

import numpy as np
import pytest

from instrument.schemes import Light, Observation, fourier_reading, in_play_order, moment_reading, scheme_of
from instrument.schemes.columns import Column
from protocols import Floats
from tests.support.plans import plan_of

FRAMES = 10
FOURIER = fourier_reading(scheme_of(plan_of("fourier-hadamard", FRAMES)).columns, 64.0)
MOMENT = moment_reading(scheme_of(plan_of("moment-hadamard", FRAMES)).columns, 128)


def light(values: Floats, variance: float = 4.0, *, photon_counts: bool = False) -> Light:
    """A total of 100 that is sure."""
    total = np.full(len(values), 100.0)
    valid = np.ones(len(values), np.bool_)
    return Light(values, np.full_like(values, variance), total, np.zeros(len(values)), valid, photon_counts)


def fringes(place_px: float, amplitude: float = 0.5) -> Floats:
    """Values of the six patterns, of an object at ``place_px`` along both axes: S/2 (1 + a cos(phase + 2 pi p / 64))."""
    angle = 2 * np.pi * place_px / 64
    pair = [50 + 50 * amplitude * np.cos(angle), 50 - 50 * amplitude * np.sin(angle)]
    return np.tile([*pair, *pair, 50.0, 50.0], (FRAMES, 1))


@pytest.mark.parametrize("place_px", [0.0, 5.0, -31.0])
def test_a_signal_is_the_fourier_coefficient_over_the_total_light(place_px: float) -> None:
    found = Observation.of(FOURIER, light(fringes(place_px)))
    np.testing.assert_allclose(found.signal, 0.5 * np.exp(-2j * np.pi * place_px / 64), atol=1e-12)
    np.testing.assert_allclose(FOURIER.displacement_px(found.signal, FOURIER.origin), place_px, atol=1e-9)


def test_the_variance_of_a_phase_is_that_of_its_values_over_the_squared_amplitude() -> None:
    """Values of variance 4 in 100: parts of 2 x 4 / 100^2 x 2 = 16e-4 each; over 0.5^2, times (64 / 2 pi)^2."""
    found = Observation.of(FOURIER, light(fringes(5.0)))
    expected = (2 / 100) ** 2 * 4 / 0.5**2 * (64 / (2 * np.pi)) ** 2
    steady = replace(
        found, signal=found.signal[:5], light=light(fringes(5.0)[:5])
    )  # too few frames to see the noise in
    np.testing.assert_allclose(steady.variance_px2(np.full((5, 2), 5.0)), expected)


def test_the_size_of_the_variance_is_what_the_amplitude_shows() -> None:
    """Amplitudes of 0.5 and 0.52 in turn: jumps of 0.02 are a deviation of 0.02 / sqrt(2), whatever the values' variance."""
    values = fringes(0.0)
    values[1::2, [0, 2]] = 50 + 50 * 0.52
    for variance in (1.0, 9.0):
        found = Observation.of(FOURIER, light(values, variance))
        mean, deviation = found.amplitude()
        np.testing.assert_allclose(mean, 0.51)
        np.testing.assert_allclose(deviation, 0.02 / np.sqrt(2))
        expected = (0.02**2 / 2) / 0.51**2 * (64 / (2 * np.pi)) ** 2
        np.testing.assert_allclose(found.variance_px2(np.zeros((FRAMES, 2))), expected)


@pytest.mark.parametrize(("frames", "known"), [(8, False), (9, True)])
def test_eight_jumps_are_needed_to_see_the_noise_of_an_amplitude(frames: int, *, known: bool) -> None:
    found = Observation.of(FOURIER, light(fringes(0.0)[:frames]))
    assert bool(np.isfinite(found.amplitude()[1]).all()) is known


def test_a_frame_of_unknown_variance_makes_all_unknown() -> None:
    seen = light(fringes(0.0))
    seen.variance[3, 0] = np.inf
    assert np.isinf(Observation.of(FOURIER, seen).variance_px2(np.zeros((FRAMES, 2)))).all()


def test_a_frame_that_is_not_valid_is_unknown_and_its_signal_nothing() -> None:
    seen = light(fringes(5.0))
    seen.valid[2] = False
    seen.values[2] = np.nan
    found = Observation.of(FOURIER, seen)
    assert found.signal[2].tolist() == [0, 0]
    variance = found.variance_px2(np.full((FRAMES, 2), 5.0))
    assert np.isinf(variance[2]).all()
    assert np.isfinite(np.delete(variance, 2, axis=0)).all()


def test_a_centroid_has_the_variance_of_its_ramp_and_of_the_total() -> None:
    """P = 128 I / S - 1/2: 128^2 x 4 / 100^2 of the value, and (p + 1/2)^2 / 100^2 for each unit of variance of S."""
    values = np.tile([50.0, 25.0, 50.0, 50.0], (FRAMES, 1))
    found = Observation.of(MOMENT, light(values))
    np.testing.assert_allclose(found.signal.real, np.tile([63.5, 31.5], (FRAMES, 1)))
    assert found.period_px is None
    assert found.amplitude_px(found.signal.real) is None
    np.testing.assert_allclose(found.variance_px2(found.signal.real), 128**2 * 4 / 100**2)
    unsure = replace(found, light=replace(found.light, total_variance=np.full(FRAMES, 9.0)))
    added = unsure.variance_px2(found.signal.real) - found.variance_px2(found.signal.real)
    np.testing.assert_allclose(added, np.tile([64.0**2, 32.0**2], (FRAMES, 1)) * 9 / 100**2)


def test_photons_are_as_unsure_as_those_expected_and_not_as_those_that_came() -> None:
    """At 63.5 px of 128 half of 100 photons are expected: a variance of 50, whatever the values' own is."""
    values = np.tile([50.0, 50.0, 50.0, 50.0], (FRAMES, 1))
    found = Observation.of(MOMENT, light(values, variance=1e6, photon_counts=True))
    np.testing.assert_allclose(found.variance_px2(np.full((FRAMES, 2), 63.5)), 128**2 * 50 / 100**2)


def test_each_pattern_sees_the_object_where_it_was_at_its_own_time() -> None:
    """One moment pattern in the first half of a frame, at 4 px a frame: seen 1 px before the middle."""
    columns = in_play_order(Column(role="moment", axis="x"), Column(role="moment", axis="y"))
    reading = moment_reading(columns, 128)
    assert reading.after_middle_frames.tolist() == [[-0.25], [0.25]]
    path = np.outer(np.arange(FRAMES), [4.0, 4.0])
    found = Observation.of(reading, light(np.full((FRAMES, 2), 50.0)))
    np.testing.assert_allclose(found.expected_direction(path).real, path + np.array([-1.0, 1.0]))
    np.testing.assert_allclose(found.in_mid_frame_px(path), 63.5 - np.array([-1.0, 1.0]) + 0 * path)


def test_an_accelerated_object_is_met_too() -> None:
    """P = k^2 px: half a frame squared is another 1/32 for the quarter of a frame."""
    columns = in_play_order(Column(role="moment", axis="x"), Column(role="moment", axis="y"))
    found = Observation.of(moment_reading(columns, 128), light(np.full((FRAMES, 2), 50.0)))
    frame = np.arange(FRAMES, dtype=np.float64)
    seen = found.expected_direction(np.stack([frame**2, frame**2], axis=1)).real[3:-3]
    np.testing.assert_allclose(seen, np.stack([(frame - 0.25) ** 2, (frame + 0.25) ** 2], axis=1)[3:-3])
