"""Displacement from recordings computed straight from the formulas, with the figures that the product promises."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from instrument.measurement import Measurement
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.schemes import FourierHadamardSettings
from instrument.tracking import Trajectory, track
from protocols import Floats, InputError
from tests.support.motions import FRAMES, MOTIONS, letter_b
from tests.support.simulation import Path2D, simulate

SEEDS = range(5)
PLACES = [(6, 10), (12, 16), (14, 18), (9, 12), (11, 8)]
"""Where the "B" starts: the error of dithered patterns is another one at each place."""


@cache
def _noisy(motion: str, seed: int, sigma: float = 0.1) -> Recording:
    return simulate(Plan(frames=FRAMES), letter_b(*PLACES[seed % 5]), MOTIONS[motion], sigma=sigma, seed=seed)


def _error(found: Trajectory, recording: Recording) -> Floats:
    assert recording.truth is not None
    return found.displacement_px - recording.truth.displacement_px


def _mse(found: Trajectory, recording: Recording) -> float:
    return float((_error(found, recording) ** 2).mean())


def _offset_free(found: Trajectory, recording: Recording) -> float:
    return float(_error(found, recording).var(axis=0).mean())


def test_an_object_that_goes_right_and_down_has_growing_x_and_y() -> None:
    """The sign: dx = -arg(O~ conj O~_ref) / (2 pi f). 0.04 px a frame to the right, 0.02 down."""

    def path(time_s: Floats) -> Floats:
        return np.stack([0.04 * time_s / 3e-4, 0.02 * time_s / 3e-4], axis=1)

    recording = simulate(Plan(frames=1001), letter_b(), path)

    for method in ("per-frame", "smooth"):
        end = track(recording, method).displacement_px[-1]
        np.testing.assert_allclose(end, [40, 20], atol=0.5)


@pytest.mark.parametrize("motion", ["I", "II"])
def test_smooth_motion_under_the_papers_noise_meets_the_bar_frame_by_frame_and_smoothed(motion: str) -> None:
    """Each frame alone: 0.2 px^2, and frame 0's own error, whose square changes from seed to seed. Smoothed: 0.03 at most."""
    alone: list[float] = []
    bar: list[float] = []
    sharp: list[float] = []
    for seed in SEEDS:
        recording = _noisy(motion, seed)
        alone.append(_offset_free(track(recording, "per-frame"), recording))
        bar.append(_mse(track(recording), recording))
        sharp.append(_offset_free(track(recording), recording))

    assert 0.19 < np.mean(alone) < 0.22
    assert np.mean(bar) < 0.03
    assert np.mean(sharp) < 0.005


def test_noise_free_error_is_that_of_the_dithered_patterns_alone() -> None:
    """Frame 0's, mostly, so it hangs on the place of the start: 0.005 to 0.05 px^2, mean 0.015; 0.004 at two samples a pixel."""

    def over_places(upsampling: int) -> Floats:
        plan = Plan(frames=400, scheme=FourierHadamardSettings(upsampling=upsampling))
        found: list[float] = []
        for top, left in np.random.default_rng(0).integers(0, 22, (16, 2)).tolist():
            recording = simulate(plan, letter_b(top, left), lambda time_s: MOTIONS["I"](time_s * FRAMES / 400))
            found.append(_mse(track(recording, "per-frame"), recording))
        return np.array(found)

    plain, finer = over_places(1), over_places(2)
    assert 0.012 < plain.mean() < 0.018
    assert 0.004 < plain.min() < plain.max() < 0.055
    assert 0.003 < finer.mean() < 0.005


@pytest.mark.parametrize(
    "motion",
    [pytest.param("vibration-50", marks=pytest.mark.thorough), "vibration-200", "circle", "random-walk", "stop-and-go"],
)
def test_rough_motion_is_followed_never_worse_than_frame_by_frame(motion: str) -> None:
    for seed in SEEDS:
        recording = _noisy(motion, seed)
        alone, smooth = track(recording, "per-frame"), track(recording)
        assert _offset_free(smooth, recording) < 0.4 * _offset_free(alone, recording)
        assert _mse(smooth, recording) < _mse(alone, recording)


def test_the_stated_95_percent_interval_covers_90_to_98_percent_of_frames() -> None:
    """Over starting places, seeds and motions; every run shares frame 0's error among its frames, so it takes many."""
    alone: list[float] = []
    smooth: list[float] = []
    for seed in range(24):
        place = np.random.default_rng(seed).integers(4, 18, 2).tolist()
        motion = MOTIONS["I" if seed % 2 else "II"]
        recording = simulate(Plan(frames=FRAMES), letter_b(*place), motion, sigma=0.1, seed=100 + seed)
        alone.append(_covered(track(recording, "per-frame"), recording))
        smooth.append(_covered(track(recording), recording))

    assert 0.90 <= np.mean(alone) <= 0.98
    assert 0.90 <= np.mean(smooth) <= 0.98


def _covered(found: Trajectory, recording: Recording) -> float:
    return float((np.abs(_error(found, recording))[1:] <= 1.96 * found.sigma_px[1:]).mean())


@pytest.mark.parametrize("counts", [50, 250])
def test_photon_counts_too_low_for_single_frames_are_tracked_without_slips(counts: int) -> None:
    """Counts of an all-on pattern. A slip is 64 px."""
    for seed in range(3):
        recording = simulate(Plan(frames=FRAMES), letter_b(), MOTIONS["II"], peak_counts=counts, seed=seed)
        assert _mse(track(recording), recording) < 60 / counts


def test_patterns_are_taken_at_their_own_times() -> None:
    """3 px a frame round a circle: the x pair is shown a third of a frame early, which is 1 px. No noise."""
    recording = _noisy("circle", 0, sigma=0.0)

    assert _mse(track(recording, "per-frame"), recording) > 0.25
    assert _mse(track(recording), recording) < 0.06


def test_a_drifting_and_flickering_lamp_does_not_move_the_object() -> None:
    flicker = np.random.default_rng(4).normal(size=FRAMES)

    def light(time_s: Floats) -> Floats:
        frame = (time_s / 3e-4).astype(np.int64)
        return 1 + 0.2 * np.sin(6 * time_s) + 0.05 * flicker[frame]

    recording = simulate(Plan(frames=FRAMES), letter_b(), MOTIONS["I"], sigma=0.1, light=light, seed=1)

    assert _mse(track(recording), recording) < 0.03


def test_frames_that_are_not_valid_are_bridged_and_marked() -> None:
    recording = _noisy("I", 1)
    bad = np.random.default_rng(0).random(FRAMES) < 0.1
    bad[:3] = bad[400:460] = True
    values = recording.values.copy()
    values[bad] = np.nan
    broken = replace(recording, values=values, frame_valid=~bad)

    found = track(broken)

    assert _mse(found, recording) < 0.06
    np.testing.assert_array_equal(found.valid, ~bad)
    assert np.isfinite(found.sigma_px).all()


def test_a_frame_with_a_missing_value_counts_as_not_valid_whatever_the_mask_says() -> None:
    recording = _noisy("I", 1).first(50)
    values = recording.values.copy()
    values[7, 2] = np.nan

    found = track(replace(recording, values=values), "per-frame")

    assert np.flatnonzero(~found.valid).tolist() == [7]
    assert np.isinf(found.sigma_px[7]).all()
    np.testing.assert_allclose(found.displacement_px[7], found.displacement_px[[6, 8]].mean(axis=0))


@pytest.mark.parametrize("method", ["per-frame", "smooth"])
@pytest.mark.parametrize("frames", [1, 2, 3, 7, 8, 12])
def test_few_frames_give_finite_displacements_and_honest_uncertainty(method: str, frames: int) -> None:
    recording = _noisy("I", 1).first(frames)

    found = track(recording, "smooth" if method == "smooth" else "per-frame")

    assert np.isfinite(found.displacement_px).all()
    assert found.displacement_px[0].tolist() == [0.0, 0.0]
    assert found.sigma_px[0].tolist() == [0.0, 0.0]
    if frames == 2:
        assert np.isinf(found.sigma_px[1]).all()


@pytest.mark.parametrize("method", ["per-frame", "smooth"])
def test_an_object_at_rest_without_noise_stays_at_zero(method: str) -> None:
    recording = simulate(Plan(frames=100), letter_b(), lambda time_s: np.zeros((len(time_s), 2)))

    found = track(recording, "smooth" if method == "smooth" else "per-frame")

    assert np.abs(found.displacement_px).max() < 1e-9
    assert found.sigma_px.max() < 1e-6


@pytest.mark.parametrize("method", ["per-frame", "smooth"])
@pytest.mark.parametrize("value", [0.0, np.nan])
def test_a_recording_without_light_is_refused(method: str, value: float) -> None:
    recording = _noisy("I", 1).first(20)

    with pytest.raises(InputError, match="no frame with light"):
        track(replace(recording, values=np.full((20, 6), value)), "smooth" if method == "smooth" else "per-frame")


def test_a_stationary_background_is_taken_off_before_or_found_in_the_run() -> None:
    """Without either, its light moves the circles of both coefficients: the error was above 1 px^2."""
    plan = Plan(frames=400)
    background = letter_b(80, 80)
    path: Path2D = MOTIONS["I"]
    alone = simulate(plan, letter_b(), path, sigma=0.05, seed=1)
    behind = simulate(plan, background, lambda time_s: np.zeros((len(time_s), 2)), sigma=0.05, seed=2)
    both = replace(alone, values=alone.values + behind.values)

    measurement = Measurement.of(both)
    assert _mse(track(replace(measurement, light_found=True)), alone) > 1
    assert _mse(track(both), alone) < 0.1
    assert _mse(track(both.minus(behind)), alone) < 0.1


def test_frames_at_rest_make_a_better_reference() -> None:
    """100 frames at rest: frame 0's own error, half of the whole, goes."""

    def path(time_s: Floats) -> Floats:
        distance_px = 40 * np.maximum(time_s - 0.03, 0)
        return np.stack([distance_px, distance_px], axis=1)

    one: list[float] = []
    many: list[float] = []
    for seed in SEEDS:
        recording = simulate(Plan(frames=800), letter_b(), path, sigma=0.1, seed=seed)
        one.append(_mse(track(recording, "per-frame"), recording))
        many.append(_mse(track(recording, "per-frame", reference_frames=100), recording))

    assert np.mean(many) < 0.8 * np.mean(one)
    assert np.mean(many) < 0.26


def test_the_five_point_mean_filter_takes_four_fifths_of_the_noise() -> None:
    recording = _noisy("II", 0)

    plain = _offset_free(track(recording, "per-frame"), recording)
    filtered = _offset_free(track(recording, "per-frame", mean_filter=5), recording)

    assert 0.17 < filtered / plain < 0.27


def test_settings_that_make_no_sense_are_refused() -> None:
    recording = _noisy("I", 1).first(20)
    first_lost = replace(recording, frame_valid=np.arange(20) > 0)

    with pytest.raises(InputError, match="a mean filter of 4"):
        track(recording, "per-frame", mean_filter=4)
    with pytest.raises(InputError, match="no valid frame among the first 1"):
        track(first_lost, "per-frame")


@pytest.mark.parametrize("valid", [40, 5])
def test_a_path_relative_to_another_frame_is_the_same_path_known_from_there(valid: int) -> None:
    """Of the last frames alone, frame 0 lies far from any that was measured."""
    recording = simulate(Plan(frames=60, image_size=64), letter_b(2, 3)[:64, :64], MOTIONS["II"], sigma=0.02)
    recording = replace(recording, frame_valid=np.arange(60) >= 60 - valid)
    first = 60 - valid
    far, near = track(recording), track(recording, reference_frame=first)
    np.testing.assert_allclose(near.displacement_px, far.displacement_px - far.displacement_px[first], atol=1e-9)
    assert (near.reference_frame, near.sigma_px[first].tolist()) == (first, [0, 0])
    assert (near.sigma_px[first + 1 :] < 0.5 * far.sigma_px[first + 1 :]).all()
    if near.covariance is not None:
        diagonal = np.diagonal(near.covariance.covariance_px2, axis1=1, axis2=2)
        np.testing.assert_allclose(diagonal.T, near.sigma_px[near.covariance.frame] ** 2, rtol=1e-6)
    assert (near.covariance is None) == (valid < 8)


@pytest.mark.parametrize(
    ("method", "frame", "saw"),
    [
        ("smooth", 60, "60 in a recording of 60"),
        ("smooth", -1, "-1 in a"),
        ("per-frame", 3, "3 for the method per-frame"),
    ],
)
def test_a_reference_frame_that_is_none_is_refused(method: Any, frame: int, saw: str) -> None:
    recording = simulate(Plan(frames=60, image_size=64), letter_b(2, 3)[:64, :64], MOTIONS["II"], sigma=0.02)
    with pytest.raises(InputError, match=f"the reference frame {saw}"):
        track(recording, method, reference_frame=frame)
