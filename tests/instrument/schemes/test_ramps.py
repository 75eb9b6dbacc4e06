"""The ramps of the first frames of the six-pattern scheme: what they are, and what the rest of the run makes of them."""

import numpy as np
import pytest
from pydantic import ValidationError

from instrument import simulate
from instrument.measurement import Measurement
from instrument.schemes import Ramps, image_rows_of, position_of, scheme_of
from protocols import Floats
from tests.support.motions import letter_b
from tests.support.plans import plan_of

RAMPS = Ramps(size=32, upsampling=1, frames=64, positive=4, negative=5)


def _still(time_s: Floats) -> Floats:
    return np.zeros((len(time_s), 2))


def test_a_centroid_by_hand() -> None:
    """Of m = 32: 32 (6 - 2) / (2 x 8) + 15.5 = 23.5 px for a ramp that rises, 7.5 px for one that falls."""
    frame = np.array([0, 4])
    found = RAMPS.centroid_px(frame, np.array([6.0, 6.0]), np.array([2.0, 2.0]), np.array([8.0, 8.0]))

    assert RAMPS.falls(np.arange(10)).tolist() == [False] * 4 + [True] * 4 + [False] * 2
    assert RAMPS.axis(np.arange(4)).tolist() == [0, 1, 0, 1]
    assert found.tolist() == [23.5, 7.5]


def test_each_column_of_a_ramp_has_exactly_as_many_lit_samples_as_its_number_or_one_more() -> None:
    """In turn: the mean of two is u + 1/2 of 32, which is grey (u + 1/2) / 32."""
    for frame, of_column in (
        (0, np.arange(32)),
        (2, np.arange(32) + 1),
        (4, 32 - np.arange(32)),
        (6, 31 - np.arange(32)),
    ):
        np.testing.assert_array_equal(RAMPS.pattern(frame).sum(axis=0), of_column)
        np.testing.assert_array_equal(RAMPS.pattern(frame + 1).sum(axis=1), of_column)


def test_lit_samples_are_spread_along_a_column_and_elsewhere_in_the_next_frame() -> None:
    """Any quarter of a half-lit column is half lit, within a sample and a half; frames of one kind differ."""
    ramp = RAMPS.pattern(0)[:, 16]
    assert np.abs(ramp.reshape(4, 8).sum(axis=1) - 4).max() <= 1
    assert (RAMPS.pattern(0) != RAMPS.pattern(8)).any()
    assert (RAMPS.pattern(0)[:, 15] != RAMPS.pattern(0)[:, 16]).sum() > 2


def test_all_ramps_together_are_grey_ramps_without_a_bias_anywhere() -> None:
    """16 frames of each kind along each axis, rows and columns alike: within 1/8 of a step of 1/32 for a block of 8 x 8."""
    frames = np.arange(64)
    rising = np.where(RAMPS.falls(frames)[:, None, None], 1 - RAMPS.patterns(), RAMPS.patterns()).astype(np.float64)
    grey = np.broadcast_to((np.arange(32) + 0.5) / 32, (32, 32))
    for axis in (0, 1):
        mean = rising[RAMPS.axis(frames) == axis].mean(axis=0)
        error = (mean if axis == 0 else mean.T) - grey
        assert np.abs(error.reshape(4, 8, 4, 8).mean(axis=(1, 3))).max() < 1 / 32 / 4


def test_the_sequence_shows_ramps_first_and_then_the_hadamard_patterns_from_their_first_on() -> None:
    plan = plan_of("fourier-hadamard", frames=20, image_size=16, superpixel=2, moment_frames=6)
    scheme = scheme_of(plan)
    sequence = scheme.sequence()
    shown = [sequence.sample_plane(int(k)) for k in sequence.play_order]
    reading = position_of(scheme)
    assert reading.ramps is not None

    for frame in range(6):
        np.testing.assert_array_equal(shown[6 * frame + 4], reading.ramps.pattern(frame))
        np.testing.assert_array_equal(shown[6 * frame + 5], 1 - reading.ramps.pattern(frame))
    assert shown[6 * 6 + 4].all()
    assert not shown[6 * 6 + 5].any()
    plain = scheme_of(plan_of("fourier-hadamard", frames=14, image_size=16, superpixel=2)).sequence()
    for k in range(14 * 6):
        np.testing.assert_array_equal(shown[36 + k], plain.sample_plane(int(plain.play_order[k])))
    assert not shown[-1].any()
    rows = image_rows_of(scheme)
    assert rows.pairs[:8].tolist() == [[0, 0]] * 7 + [[0, 1]]
    assert rows.is_ramp(np.arange(22)).tolist() == [True] * 6 + [False] * 14 + [True] * 2


def test_a_run_longer_than_all_patterns_shows_the_ramps_again() -> None:
    scheme = scheme_of(plan_of("fourier-hadamard", frames=70, image_size=8, superpixel=2, moment_frames=4))
    sequence = scheme.sequence()
    order = np.asarray(sequence.play_order[:-1]).reshape(70, 6)

    np.testing.assert_array_equal(order[64:], order[:6])
    assert len(sequence.planes) == 4 + 2 * 64
    assert np.flatnonzero(image_rows_of(scheme).is_ramp(np.arange(70))).tolist() == [0, 1, 2, 3, 64, 65, 66, 67]


def test_the_image_takes_a_ramp_and_its_complement_for_the_all_on_pattern_and_once_for_all_of_them() -> None:
    plan = plan_of("fourier-hadamard", frames=40, image_size=32, superpixel=2, moment_frames=10)
    image = letter_b(2, 2, 48)[:32, :32]
    recording = simulate(plan, {"noise": {"kind": "pixel", "sigma": 0.01, "seed": 1}}, image=image, path=_still)
    values = Measurement.of(recording).image_values(steady_object=False)

    np.testing.assert_allclose(values.positive[:11], image.sum(), rtol=0.02)
    np.testing.assert_allclose(values.negative[:10], 0.0)
    assert (values.pairs[:11] == 0).all()
    np.testing.assert_allclose(values.difference_variance[:10] / values.difference_variance[10], 10, rtol=1e-6)


def test_coefficients_and_total_light_of_a_frame_with_a_ramp_are_those_of_any_other() -> None:
    plan = plan_of("fourier-hadamard", frames=30, image_size=32, superpixel=2, moment_frames=10)
    recording = simulate(plan, image=letter_b(2, 2, 48)[:32, :32], path=_still)
    measurement = Measurement.of(recording)

    np.testing.assert_allclose(measurement.total, measurement.total[-1], rtol=1e-9)
    signal = measurement.observe(steady=False).signal
    np.testing.assert_allclose(signal, np.broadcast_to(signal[-1], signal.shape), atol=1e-9)


def test_more_ramps_than_half_of_the_patterns_are_refused() -> None:
    with pytest.raises(ValidationError, match="moment_frames is 33: at most half of the 64 Hadamard patterns"):
        plan_of("fourier-hadamard", frames=70, image_size=8, superpixel=2, moment_frames=33)
    plan_of("fourier-hadamard", frames=70, image_size=8, superpixel=2, moment_frames=32)
